"""What `activesuit bench` measures, one topic a file."""
