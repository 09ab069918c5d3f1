"""What motions cost the muscles: MyoArm's muscles give the wearer's torque (extra `muscles`)."""

from .analysis import CONVENTIONS, STANDARD, muscle_activation
from .myoarm import GROUPS, MyoArm, myoarm_spec
from .scores import MuscleScore, muscle_relief, muscle_scores, relief_range

__all__ = [
    "CONVENTIONS",
    "GROUPS",
    "STANDARD",
    "MuscleScore",
    "MyoArm",
    "muscle_activation",
    "muscle_relief",
    "muscle_scores",
    "myoarm_spec",
    "relief_range",
]
