"""The joint on which a file of curves was measured, and the motions that its model is for."""

from pathlib import Path

from ..arrays import Array
from ..assets import JOINTS
from ..errors import InputError, unknown_name
from ..identification import load_motion
from ..identification.data.files import Motion
from ..identification.identify import ANY

MOTION = ".csv"  # how the names of files of motions end
MOTIONS = 20  # number of motions of a task, the same as in `evaluate`


def joint_of(path: Path, joint: str | None, *, needed: bool = True) -> str | None:
    """Returns `joint`, or the joint that a file's name says; None where no joint is needed."""
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
    """Returns whether a use is the name of a task, whose motions are those of several joints."""
    return use not in (None, ANY) and not use.lower().endswith(MOTION)


def intended_motions(use: str | None, joint: str | None) -> list[Motion]:
    """Returns the motions of a use; none where there is no use, or any motion is one.

    Args:
        use: Name of a task, path of a CSV file of a motion, or "any"; None for no use.
        joint: Name of the joint, which a task needs.
    """
    if use is None or use == ANY:
        return []
    return _task_motions(use, str(joint)) if is_task(use) else [load_motion(use, joint)]


def _task_motions(name: str, joint: str) -> list[Motion]:
    """Returns what a joint of the intended arm does in motions of a task."""
    import numpy as np

    from ..envs import ArmEnv  # MuJoCo takes a second to import
    from ..envs.evaluation import FIRST_SEED
    from ..envs.tasks import TASKS

    if name not in TASKS:
        raise unknown_name("use", name, [*TASKS, ANY, f"a file *{MOTION}"])
    env = ArmEnv(TASKS[name], coupling="none")
    simulation, column = env.episodes.simulation, [*map(str, JOINTS)].index(joint)
    found: list[Motion] = []
    for seed in range(FIRST_SEED, FIRST_SEED + MOTIONS):
        env.reset(seed=seed)
        angle: Array = simulation.state.intention.motion.angle[0, :, column].copy()
        time: Array = simulation.control_dt * np.arange(angle.size, dtype=np.float64)
        found.append(Motion(time, angle))
    env.close()
    return found
