"""The commands of `activesuit`: each is a function in a file with its name."""
