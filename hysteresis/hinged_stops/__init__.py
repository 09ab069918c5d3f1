"""Hinged stops, a Prandtl-Ishlinskii model behind a hinge function: the class and its kernels."""

from .model import HingedStops

__all__ = ["HingedStops"]
