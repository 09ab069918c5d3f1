"""The wearer as a person: size, strength, and how they act."""

from .anthropometry import Person, Segment, range_of_motion, segments
from .strength import isometric_strength, passive_torque, strength_limits

__all__ = [
    "Person",
    "Segment",
    "isometric_strength",
    "passive_torque",
    "range_of_motion",
    "segments",
    "strength_limits",
]
