"""Tasks: what a wearer does, one file a family, from isolated joints to tools and loads."""

from pathlib import PurePath

from ...errors import InputError, unknown_name
from ..simulation.episode_plan import Plan
from .joints import (
    ARM_TRACKING,
    ELBOW_FLEXION,
    MINOR_LOOPS,
    RANGE_OF_MOTION,
    SHOULDER_FLEXION,
    TRANSITION_CURVES,
    MinorLoops,
    RandomMoves,
    RangeOfMotion,
    TransitionCurves,
)
from .places import HANDRAIL, OBJECT_RELOCATION, REACH_PANEL, Handrail, ObjectRelocation, ReachPanel
from .recorded import MOTION, RecordedMotion
from .task import Task
from .tools import HAMMER, OVERHEAD_HOLD, RATCHET, SCOOP, Hammer, OverheadHold, Ratchet, Scoop

__all__ = [
    "ARM_TRACKING",
    "TASKS",
    "Hammer",
    "Handrail",
    "MinorLoops",
    "ObjectRelocation",
    "OverheadHold",
    "Plan",
    "RandomMoves",
    "RangeOfMotion",
    "Ratchet",
    "ReachPanel",
    "RecordedMotion",
    "Scoop",
    "Task",
    "TransitionCurves",
    "task_of",
]

TASKS: dict[str, Task] = {
    task.name: task
    for task in (
        *(SHOULDER_FLEXION, ELBOW_FLEXION, ARM_TRACKING, RANGE_OF_MOTION, TRANSITION_CURVES),
        *(MINOR_LOOPS, REACH_PANEL, OBJECT_RELOCATION, HANDRAIL, RATCHET, HAMMER, SCOOP),
        OVERHEAD_HOLD,
    )
}


def task_of(given: str | Task) -> Task:
    """Returns a task: the given task, a shipped task by name, or the motion of a CSV file."""
    if isinstance(given, Task):
        return given
    if not isinstance(given, str):
        raise InputError(f"task is a {type(given).__name__}: give a Task, or the name of one")
    if given.lower().endswith(MOTION):
        return RecordedMotion(name=PurePath(given).stem, path=given)
    if given not in TASKS:
        raise unknown_name("task", given, TASKS)
    return TASKS[given]
