"""What motions cost the muscles: MyoArm's muscles give the wearer's torque (extra `muscles`).

Importing this package registers `ActiveSuit/MuscleElbow-v0` with Gymnasium.
"""

import gymnasium

from .analysis import CONVENTIONS, STANDARD, muscle_activation
from .myoarm import GROUPS, MyoArm, myoarm_spec
from .scores import muscle_scores

__all__ = [
    "CONVENTIONS",
    "GROUPS",
    "STANDARD",
    "MyoArm",
    "muscle_activation",
    "muscle_scores",
    "myoarm_spec",
]

if "ActiveSuit/MuscleElbow-v0" not in gymnasium.registry:
    gymnasium.register(
        "ActiveSuit/MuscleElbow-v0", entry_point="activesuit.envs.muscles.elbow:MuscleElbow"
    )
