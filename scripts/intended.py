"""What an intended use needs of curves: the motions of a task, of a file, or any."""

from collections.abc import Sequence
from pathlib import Path

from ..arrays import Array
from ..assets import JOINTS
from ..errors import unknown_name
from ..identification import Coverage, Curves, coverage, load_motion, motion_coverage
from ..identification.coverage import any_motion
from ..identification.motion_files import Motion
from .curve_joints import joint_of

ANY = "any"
MOTION = ".csv"  # how the names of files of motions end
MOTIONS = 20  # number of motions of a task, the same as in `evaluate`


def needed_coverage(curves: Curves, use: str | None, motions: Sequence[Motion]) -> Coverage | None:
    """Returns what a use needs of curves; None without a use.

    Args:
        curves: Measured curves.
        use: Use of the curves, as in `intended_motions`.
        motions: Its motions.
    """
    if use == ANY:
        return any_motion(coverage(curves.fitted() or curves))
    return motion_coverage(motions) if motions else None


def intended_motions(path: Path, use: str | None, joint: str | None) -> list[Motion]:
    """Returns the motions of a use; none where there is no use, or any motion is one.

    Args:
        path: Path of the file of curves, whose name may tell the joint.
        use: Name of a task, path of a CSV file of a motion, or "any"; None for no use.
        joint: Name of the joint, if it is given.
    """
    if use is None or use == ANY:
        return []
    if use.lower().endswith(MOTION):
        return [load_motion(use, _joint_if_known(path, joint))]
    return _task_motions(use, joint_of(path, joint))


def _joint_if_known(path: Path, joint: str | None) -> str | None:
    known = joint is not None or {path.stem, f"{path.stem}_flexion"} & {*JOINTS}
    return joint_of(path, joint) if known else None


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
