"""The commands of `activesuit`, one a file: a function of the file's name."""
