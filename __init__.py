"""ActiveSuit: hysteretic spacesuit joints, and an exoskeleton that cancels their torque.

Importing this package registers the environments `ActiveSuit/...` with Gymnasium; the other parts
load when they are imported.
"""

import gymnasium

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


def __getattr__(name: str) -> object:
    if name == "load":
        raise AttributeError(
            "activesuit.load is activesuit.envs.model.load_model since version 0.3: import that"
        )
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
