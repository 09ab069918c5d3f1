"""The measurements of `python -m activesuit.benchmarks`, one topic a file."""
