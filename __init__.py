"""ActiveSuit: hysteretic spacesuit joints, an exoskeleton that cancels them, and the tools between.

Importing this package registers the environments `ActiveSuit/...` with Gymnasium; everything else
loads when it is first imported.
"""

from typing import TYPE_CHECKING

import gymnasium

if TYPE_CHECKING:
    import os

    import mujoco

__version__ = "0.2.0"

TASKS = (
    *("ShoulderFlexion", "ElbowFlexion", "ArmTracking", "RangeOfMotion", "TransitionCurves"),
    *("MinorLoops", "ReachPanel", "ObjectRelocation", "Handrail", "Ratchet", "Hammer", "Scoop"),
    "OverheadHold",
)

for _task in TASKS:
    if f"ActiveSuit/{_task}-v0" not in gymnasium.registry:
        gymnasium.register(
            f"ActiveSuit/{_task}-v0",
            entry_point="activesuit.envs.arm_env:ArmEnv",
            vector_entry_point="activesuit.envs.vector_env:ArmVectorEnv",
            kwargs={"task": _task},
        )


def load(path: "str | os.PathLike[str]") -> "mujoco.MjModel":
    """Returns a MuJoCo model from a file, .xml or .mjb, with the plugins of this package.

    See `activesuit.envs.model.loading.load_model`, which says what a binary file cannot tell.

    Args:
        path: Path of the file.

    Raises:
        InputError: There is no such file, its name ends otherwise, or MuJoCo refuses its content.
    """
    from .envs.model.loading import load_model

    return load_model(path)
