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


def told_joint(path: Path, joint: str | None) -> str | None:
    """Returns `joint`, or the joint that the name of a curve file tells; None if it tells none."""
    if joint is not None and joint not in JOINTS:
        raise unknown_name("joint", joint, JOINTS)
    return next((one for one in (joint, path.stem, f"{path.stem}_flexion") if one in JOINTS), None)


def joint_of(path: Path, joint: str | None) -> str:
    """Returns the joint that a curve file belongs to: `joint`, or what the file name says."""
    found = told_joint(path, joint)
    if found is None:
        raise untold(path)
    return found


def untold(path: Path) -> InputError:
    """Returns the error for a curve file whose joint nothing tells."""
    return InputError(
        f"cannot tell which joint {path.name!r} was measured on: give --joint with one of "
        f"{', '.join(JOINTS)}"
    )


def intended_motions(path: Path, use: str | None, joint: str | None) -> list[Motion]:
    """Returns the motions of a use; none where there is no use, or any motion is one.

    Args:
        path: Path of the file of curves.
        use: Name of a task, path of a CSV file of a motion, or "any"; None for no use.
        joint: Name of the joint; None if nothing tells it.
    """
    if use is None or use == ANY:
        return []
    if use.lower().endswith(MOTION):
        return [load_motion(use, joint)]
    if joint is None:
        raise untold(path)
    return _task_motions(use, joint)


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
