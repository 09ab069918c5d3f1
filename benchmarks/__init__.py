"""The measurements of `activesuit bench`, one topic a file."""
