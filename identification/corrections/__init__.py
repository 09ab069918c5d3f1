"""What is taken off the curves before a fit: offset, change over the cycles, noise of cycles."""
