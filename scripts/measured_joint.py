"""The joint on which a file of curves was measured, and the intended motions of its model."""

from pathlib import Path

from ..arrays import Array
from ..assets import JOINTS
from ..errors import InputError, unknown_name
from ..identification import load_motion
from ..identification.data.files import Motion
from ..identification.identify import ANY

MOTION = ".csv"  # end of the names of files of motions
MOTIONS = 20  # number of motions of a task, the same as in `evaluate`


def joint_of(path: Path, joint: str | None, *, needed: bool = True) -> str | None:
    """Returns `joint`, or the joint in the name of a file; None if no joint is found or needed."""
    if joint is not None and joint not in JOINTS:
        raise unknown_name("joint", joint, JOINTS)
    for name in (joint, path.stem, f"{path.stem}_flexion"):
        if name in JOINTS:
            return name
    if needed:
        raise InputError(
            f"cannot tell which joint {path.name!r} was measured on: give --joint with one of "
            f"{', '.join(JOINTS)}"
        )
    return None


def is_task(use: str | None) -> bool:
    """Returns whether a use is the name of a task."""
    return use not in (None, ANY) and not use.lower().endswith(MOTION)


def intended_motions(use: str | None, joint: str | None) -> list[Motion]:
    """Returns the intended motions of a joint.

    Args:
        use: Name of a task, path of a CSV file of a motion, or "any"; without a use, or with any,
            there is no motion.
        joint: Name of the joint, which a task needs.
    """
    if use is None or use == ANY:
        return []
    if not is_task(use):
        return [load_motion(use, joint)]
    import numpy as np

    from ..envs import ArmEnv  # MuJoCo takes a second to import
    from ..envs.evaluation import FIRST_SEED
    from ..envs.tasks import TASKS

    if use not in TASKS:
        raise unknown_name("use", use, [*TASKS, ANY, f"a file *{MOTION}"])
    env = ArmEnv(TASKS[use], coupling="none")
    simulation, column = env.episodes.simulation, [*map(str, JOINTS)].index(str(joint))
    found: list[Motion] = []
    for seed in range(FIRST_SEED, FIRST_SEED + MOTIONS):
        env.reset(seed=seed)
        angle: Array = simulation.state.intention.motion.angle[0, :, column].copy()
        time: Array = simulation.control_dt * np.arange(angle.size, dtype=np.float64)
        found.append(Motion(time, angle))
    env.close()
    return found
