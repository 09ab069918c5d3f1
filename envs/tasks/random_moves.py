"""Random moves between angles: of the shoulder, of the elbow, and of both."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ...assets import JOINTS
from ...errors import InputError, shown, unknown_name
from ...published import LI_RANGES
from ..simulation.plan import Motion
from .motions import random_motion
from .task import LONGEST, SUSTAINED, Task, check_pair

SHOULDER_RANGE, ELBOW_RANGE = LI_RANGES["shoulder"], LI_RANGES["elbow"]  # rad
SHORTEST_MOVE = 0.01  # s

Spans = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class RandomMoves(Task):
    """Joints that move between random angles.

    Attributes:
        span: Lowest and highest angle [rad] of the joints that move.
        hold: Lowest and highest angle [rad] of the joints that stay at a random angle.
        move_time: Shortest and longest time of a move [s].
        dwell_time: Shortest and longest rest after it [s].
    """

    span: Spans = field(default_factory=dict)
    hold: Spans = field(default_factory=dict)
    move_time: tuple[float, float] = (1.2, 2.4)
    dwell_time: tuple[float, float] = (0.0, 0.5)

    source: ClassVar[str] = "ranges of Li et al. 2022; times assumed"

    def __post_init__(self) -> None:
        super().__post_init__()
        for what in ("span", "hold"):
            _check_spans(what, getattr(self, what))
        for joint in self.span.keys() & self.hold.keys():
            raise InputError(
                f"the task's span and hold both have {joint}: a joint either moves or stays"
            )
        for what, least in (("move_time", SHORTEST_MOVE), ("dwell_time", 0.0)):
            times = getattr(self, what)
            check_pair(f"the task's {what}", times, " s")
            if not least <= times[0] <= times[1] <= LONGEST:
                raise InputError(
                    f"the task's {what} is {shown(times)}: give the shortest and the longest time, "
                    f"from {least:g} to {LONGEST:g} s"
                )

    @property
    def about(self) -> str:
        """What the wearer does, in words."""
        moved, resting = (
            " and ".join(joint.replace("_flexion", "").replace("_", " ") for joint in joints)
            for joints in (self.span, self.hold)
        )
        rest = f"; {resting} stays at one" if resting else ""
        return f"Between random angles: {moved or 'nothing'}{rest}."

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        """Returns random minimum-jerk moves; see `Task.motion`."""
        return random_motion(
            rng, self.span, self.hold, samples, dt, self.move_time, self.dwell_time
        )


def _check_spans(what: str, given: Any) -> None:
    if not isinstance(given, Mapping):
        raise InputError(f"the task's {what} is {shown(given)}: give a dict of angles by joint")
    for joint, angles in given.items():
        if joint not in JOINTS:
            raise unknown_name(f"joint in the task's {what}", joint, JOINTS)
        check_pair(f"the task's {what} of {joint}", angles, " rad")
        if not angles[0] < angles[1]:
            raise InputError(
                f"the task's {what} of {joint} is {shown(angles)}: give the smaller angle first"
            )


SHOULDER_FLEXION = RandomMoves(
    name="ShoulderFlexion",
    span={"shoulder_flexion": SHOULDER_RANGE},
    hold={"elbow_flexion": (0.6, 1.2)},
    effort=SUSTAINED,
)
"""The shoulder flexes and extends between random angles; the elbow stays at one."""

ELBOW_FLEXION = RandomMoves(
    name="ElbowFlexion",
    span={"elbow_flexion": ELBOW_RANGE},
    hold={"shoulder_flexion": (0.4, 1.0)},
    effort=SUSTAINED,
)
"""The elbow flexes and extends between random angles; the shoulder stays at one."""

ARM_TRACKING = RandomMoves(
    name="ArmTracking",
    span={"shoulder_flexion": SHOULDER_RANGE, "elbow_flexion": ELBOW_RANGE},
    effort=SUSTAINED,
)
"""Shoulder and elbow move independently between random angles."""
