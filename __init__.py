"""ActiveSuit: hysteretic spacesuit joints, an exoskeleton that cancels them, and the tools between."""

__version__ = "0.1.0"
