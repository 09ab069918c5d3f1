"""The tasks: each says which joints move, between which angles, and for how long."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..errors import InputError, unknown_name
from ..published import LI_RANGES
from .simulation.intention import Motion, random_motion

SHOULDER_RANGE, ELBOW_RANGE = LI_RANGES["shoulder"], LI_RANGES["elbow"]  # rad

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
