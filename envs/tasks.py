"""The tasks: each says which joints move, between which angles, and for how long."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..assets import JOINTS
from ..checks import within
from ..errors import InputError, shown, unknown_name
from ..published import LI_RANGES
from .simulation.intention import Motion, random_motion

SHOULDER_RANGE, ELBOW_RANGE = LI_RANGES["shoulder"], LI_RANGES["elbow"]  # rad

SHORTEST, LONGEST = 0.02, 3600.0  # s, of an episode
SHORTEST_MOVE = 0.01  # s

Spans = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class Task:
    """Joints that move between random angles; derive from it for motions of your own.

    Attributes:
        name: Name of the task.
        span: Lowest and highest angle [rad] of the joints that move.
        hold: Lowest and highest angle [rad] of the joints that are held at a random angle.
        duration: Duration of an episode [s].
        move_time: Shortest and longest time of a move [s].
        dwell_time: Shortest and longest rest after it [s].
    """

    name: str
    span: Spans = field(default_factory=dict)
    hold: Spans = field(default_factory=dict)
    duration: float = 10.0
    move_time: tuple[float, float] = (1.2, 2.4)
    dwell_time: tuple[float, float] = (0.0, 0.5)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise InputError(f"the task's name is {shown(self.name)}: give it one")
        for what in ("span", "hold"):
            _check_spans(what, getattr(self, what))
        within("the task's duration", self.duration, SHORTEST, LONGEST, " s")
        for what, least in (("move_time", SHORTEST_MOVE), ("dwell_time", 0.0)):
            times = getattr(self, what)
            _check_pair(f"the task's {what}", times, " s")
            if not least <= times[0] <= times[1] <= LONGEST:
                raise InputError(
                    f"the task's {what} is {shown(times)}: give the shortest and the longest time, "
                    f"from {least:g} to {LONGEST:g} s"
                )

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        """Returns the intended angles [rad] of an episode and two derivatives, (samples, 4) each.

        Override it for a motion of your own, with the same arm and the same wearer.

        Args:
            rng: Random generator of this episode's motion.
            samples: Number of samples, the first at the reset.
            dt: Time between samples [s].
        """
        return random_motion(
            rng, self.span, self.hold, samples, dt, self.move_time, self.dwell_time
        )


def _check_spans(what: str, given: Any) -> None:
    if not isinstance(given, Mapping):
        raise InputError(f"the task's {what} is {shown(given)}: give a dict of angles by joint")
    for joint, angles in given.items():
        if joint not in JOINTS:
            raise unknown_name(f"joint in the task's {what}", joint, JOINTS)
        _check_pair(f"the task's {what} of {joint}", angles, " rad")
        if not angles[0] < angles[1]:
            raise InputError(
                f"the task's {what} of {joint} is {shown(angles)}: give the smaller angle first"
            )


def _check_pair(name: str, given: Any, unit: str) -> None:
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise InputError(f"{name} is {shown(given)}: give two numbers")
    for value in given:
        within(name, value, -LONGEST, LONGEST, unit)


SHOULDER_FLEXION = Task(
    name="ShoulderFlexion",
    span={"shoulder_flexion": SHOULDER_RANGE},
    hold={"elbow_flexion": (0.6, 1.2)},
)
"""The shoulder flexes and extends between random angles; the elbow is held."""

ELBOW_FLEXION = Task(
    name="ElbowFlexion",
    span={"elbow_flexion": ELBOW_RANGE},
    hold={"shoulder_flexion": (0.4, 1.0)},
)
"""The elbow flexes and extends between random angles; the shoulder is held."""

ARM_TRACKING = Task(
    name="ArmTracking",
    span={"shoulder_flexion": SHOULDER_RANGE, "elbow_flexion": ELBOW_RANGE},
)
"""Shoulder and elbow move independently between random angles."""

TASKS = {task.name: task for task in (SHOULDER_FLEXION, ELBOW_FLEXION, ARM_TRACKING)}


def task_of(given: str | Task) -> Task:
    """Returns a task, or the shipped one of that name.

    Raises:
        InputError: There is no such task.
    """
    if isinstance(given, Task):
        return given
    if not isinstance(given, str):
        raise InputError(f"task is a {type(given).__name__}: give a Task, or the name of one")
    if given not in TASKS:
        raise unknown_name("task", given, TASKS)
    return TASKS[given]
