"""Slow, readable models, written from the equations, that check the kernels and the engine."""

from .models import EXAMPLES, PrandtlIshlinskiiReference
from .reference import Example, Reference, integrate, reference_of, turn_indices

__all__ = [
    "EXAMPLES",
    "Example",
    "PrandtlIshlinskiiReference",
    "Reference",
    "integrate",
    "reference_of",
    "turn_indices",
]
