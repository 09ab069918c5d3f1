"""The wearer as a person: size, strength, fatigue, control, and the effort of a motion."""

from .anthropometry import Person, Segment, range_of_motion, segments
from .control import VoluntaryControl
from .effort import EffortMetrics, effort_metrics, spectral_arc_length
from .fatigue import endurance_time
from .strength import isometric_strength, passive_torque, strength_limits

__all__ = [
    "EffortMetrics",
    "Person",
    "Segment",
    "VoluntaryControl",
    "effort_metrics",
    "endurance_time",
    "isometric_strength",
    "passive_torque",
    "range_of_motion",
    "segments",
    "spectral_arc_length",
    "strength_limits",
]
