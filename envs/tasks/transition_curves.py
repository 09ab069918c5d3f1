"""The motions by which suits are measured: whole sweeps, and first-order transition curves."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...arrays import Array
from ...published import LI_RANGES, LI_TURNS
from ..simulation.kinematics import Arm
from ..simulation.plan import Plan
from .motions import between, posture, through
from .task import SUSTAINED, Task

HOME = {"shoulder": 0.6, "elbow": 0.9}  # [rad], angle of the joint that does not move
RAMP = 2.0  # [s], time from the start of the range to a turn
TRIES = 3  # sweeps of each joint
SPEED = 0.2  # rad/s, mean of a sweep


@dataclass(frozen=True, kw_only=True)
class TransitionCurves(Task):
    """The first-order transition curves of both joints, in random order."""

    source: ClassVar[str] = "Li et al. 2022, curves of identification; ramp times assumed"

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns a curve for each published turn, first of one joint, then of the other."""
        del arm
        visits = []
        for joint in _either_first(rng):
            turns = rng.permutation(LI_TURNS[joint])
            visits += [(joint, turn, RAMP) for turn in turns]
        stops, _ = _there_and_back(visits)
        return Plan(through(stops, samples, dt))


@dataclass(frozen=True, kw_only=True)
class RangeOfMotion(Task):
    """Each joint is swept through its measured range three times, the other one at home."""

    source: ClassVar[str] = "Matty 2010 (NTRS 20100017776); ranges of Li et al. 2022"

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns three sweeps of one joint, then of the other; the ends are watched."""
        del arm
        visits = []
        for joint in _either_first(rng):
            low, high = LI_RANGES[joint]
            visits += [(joint, high, (high - low) / SPEED)] * TRIES
        stops, ends = _there_and_back(visits)
        return Plan(
            through(stops, samples, dt),
            watched=between([(end, end) for end in ends], samples, dt),
        )


def _either_first(rng: np.random.Generator) -> Sequence[str]:
    joints = ("shoulder", "elbow")
    return joints if rng.random() < 0.5 else joints[::-1]


def _there_and_back(
    visits: Sequence[tuple[str, float, float]],
) -> tuple[list[tuple[float, Array]], list[float]]:
    """Returns stops that take a joint from the start of its range to an angle and back, and ends.

    Args:
        visits: Joint, angle [rad] and time of a ramp [s] of each.
    """
    stops, ends, now = [], [], 0.0
    before = None
    for joint, angle, ramp in visits:
        low = LI_RANGES[joint][0]
        start, turn = _at(joint, low), _at(joint, angle)
        if before not in (None, joint):
            now += RAMP  # the motion changes from one joint to the other
        stops += [(now, start), (now + ramp, turn), (now + 2 * ramp, start)]
        ends += [now, now + ramp, now + 2 * ramp]
        now, before = now + 2 * ramp, joint
    stops = [stop for i, stop in enumerate(stops) if i == 0 or stop[0] > stops[i - 1][0]]
    return stops, ends


def _at(joint: str, angle: float) -> Array:
    angles = {**HOME, joint: angle}
    return posture(angles["shoulder"], angles["elbow"])


TRANSITION_CURVES = TransitionCurves(
    name="TransitionCurves", duration=42.0, tracking=0.02, effort=SUSTAINED
)
"""The published families of curves, followed to 20 mrad."""

RANGE_OF_MOTION = RangeOfMotion(
    name="RangeOfMotion", duration=60.0, tracking=0.1, effort=SUSTAINED, hand_error=0.03
)
"""Shoulder and elbow from end to end of their measured ranges, the hand within 3 cm there."""
