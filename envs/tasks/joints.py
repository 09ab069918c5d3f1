"""Motions of joints without a load: random moves, nested loops, sweeps of measured suits."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from ...assets import JOINTS
from ...checks import pair
from ...errors import InputError, shown, unknown_name
from ...published import LI_RANGES, LI_TURNS
from ..provenance import setting
from ..simulation.episode_plan import Motion, Plan
from ..simulation.kinematics import Arm
from .motions import between, posture, ramped, random_moves, through
from .task import LONGEST, SUSTAINED, Task

RANGES = {f"{joint}_flexion": angles for joint, angles in LI_RANGES.items()}  # rad
SHORTEST_MOVE = 0.01  # s

Spans = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, kw_only=True)
class RandomMoves(Task):
    """Joints that move between random angles.

    Attributes:
        span: Lowest and highest angle [rad] of the joints that move.
        hold: Lowest and highest angle [rad] of the joints that stay at a random angle.
        move_time: Shortest and longest time of a move [s].
        dwell_time: Shortest and longest rest after a move [s].
    """

    span: Spans = field(default_factory=dict)
    hold: Spans = field(default_factory=dict)
    move_time: tuple[float, float] = setting((1.2, 2.4), "s", SHORTEST_MOVE, LONGEST)
    dwell_time: tuple[float, float] = setting((0.0, 0.5), "s", 0, LONGEST)

    source: ClassVar[str] = "ranges of Li et al. 2022; times assumed"

    def __post_init__(self) -> None:
        super().__post_init__()
        for what in ("span", "hold"):
            _check_spans(what, getattr(self, what))
        for joint in self.span.keys() & self.hold.keys():
            raise InputError(
                f"the task's span and hold both have {joint}: a joint either moves or stays"
            )

    @property
    def about(self) -> str:
        """Description of the motion."""
        moved, resting = (
            " and ".join(joint.replace("_flexion", "").replace("_", " ") for joint in joints)
            for joints in (self.span, self.hold)
        )
        rest = f"; {resting} stays at one" if resting else ""
        return f"Between random angles: {moved or 'nothing'}{rest}."

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        """Returns random minimum-jerk moves; joints in neither mapping stay at zero."""
        motion = np.zeros((3, samples, len(JOINTS)))
        for joint, (low, high) in self.span.items():
            moves = random_moves(rng, low, high, samples, dt, self.move_time, self.dwell_time)
            motion[:, :, JOINTS.index(joint)] = moves
        for joint, angles in self.hold.items():
            motion[0, :, JOINTS.index(joint)] = rng.uniform(*angles)
        return motion[0], motion[1], motion[2]


def _check_spans(what: str, given: Any) -> None:
    if not isinstance(given, Mapping):
        raise InputError(f"the task's {what} is {shown(given)}: give a dict of angles by joint")
    for joint, angles in given.items():
        if joint not in JOINTS:
            raise unknown_name(f"joint in the task's {what}", joint, JOINTS)
        pair(f"the task's {what} of {joint}", angles, -LONGEST, LONGEST, " rad")


SHOULDER_FLEXION = RandomMoves(
    name="ShoulderFlexion",
    span={"shoulder_flexion": RANGES["shoulder_flexion"]},
    hold={"elbow_flexion": (0.6, 1.2)},
    effort=SUSTAINED,
)
"""The shoulder flexes and extends between random angles; the elbow stays at a random angle."""

ELBOW_FLEXION = RandomMoves(
    name="ElbowFlexion",
    span={"elbow_flexion": RANGES["elbow_flexion"]},
    hold={"shoulder_flexion": (0.4, 1.0)},
    effort=SUSTAINED,
)
"""The elbow flexes and extends between random angles; the shoulder stays at a random angle."""

ARM_TRACKING = RandomMoves(name="ArmTracking", span=RANGES, effort=SUSTAINED)
"""Shoulder and elbow move independently between random angles."""


FREQUENCIES = np.array([0.3, 0.4, 0.5, 0.6, 0.7])  # Hz
BEGINNING = 1.0  # [s], rise of the amplitude from rest


@dataclass(frozen=True, kw_only=True)
class MinorLoops(Task):
    """Shoulder and elbow move by sums of five sines with random phases."""

    source: ClassVar[str] = (
        "Li et al. 2022, future work: higher-order reversals; 0.3 to 0.7 Hz assumed"
    )

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        """Returns sums of sines that fill the measured ranges; see `Task.motion`."""
        time = dt * np.arange(samples)
        motion = np.zeros((3, samples, len(JOINTS)))
        speed = math.tau * FREQUENCIES
        for joint, (low, high) in RANGES.items():
            phase = rng.uniform(0, math.tau, FREQUENCIES.size)
            turned = speed * time[:, None] + phase
            wave = np.sin(turned).sum(axis=1)
            rate = (speed * np.cos(turned)).sum(axis=1)
            acceleration = -(speed**2 * np.sin(turned)).sum(axis=1)
            size = (high - low) / 2 / np.abs(wave).max()
            column = JOINTS.index(joint)
            grown = ramped(wave, rate, acceleration, time, BEGINNING)
            motion[:, :, column] = size * np.array(grown)
            motion[0, :, column] += (low + high) / 2
        return motion[0], motion[1], motion[2]


MINOR_LOOPS = MinorLoops(name="MinorLoops", duration=20.0, effort=SUSTAINED)
"""Nested loops of shoulder and elbow for 20 s."""


CHANGE = 2.0  # [s], from one joint to the other
TRIES = 3  # sweeps of each joint


@dataclass(frozen=True, kw_only=True)
class TransitionCurves(Task):
    """The first-order transition curves of both joints in random order, at random speeds.

    Attributes:
        ramp_time: Shortest and longest time from the start of the range to a turn, and of the way
            back [s], drawn for each turn.
        home: Lowest and highest angle at which a joint stays while the other one moves, as a share
            of its measured range.
    """

    ramp_time: tuple[float, float] = setting((1.6, 2.2), "s", SHORTEST_MOVE, LONGEST)
    home: tuple[float, float] = setting((0.1, 0.5), "of the range", 0, 1)

    source: ClassVar[str] = "Li et al. 2022, curves of identification; times and home assumed"

    def turns(self, joint: str, rng: np.random.Generator) -> Sequence[float]:
        """Returns the angles at which a joint turns back [rad]."""
        return rng.permutation(LI_TURNS[joint]).tolist()

    def plan(self, rng: np.random.Generator, samples: int, dt: float, arm: Arm) -> Plan:
        """Returns ways of one joint from the start of its range and back, then of the other joint.

        The ends of the ways are watched if the task watches the hand.
        """
        stops, ends, now = [], [], 0.0
        home = {joint: _share(joint, rng.uniform(*self.home)) for joint in LI_RANGES}
        for joint in ("shoulder", "elbow") if rng.random() < 0.5 else ("elbow", "shoulder"):
            now += CHANGE if stops else 0.0
            start = posture(**{**home, joint: LI_RANGES[joint][0]})
            stops.append((now, start))
            ends.append(now)
            for angle in self.turns(joint, rng):
                ramp = rng.uniform(*self.ramp_time)
                turned = posture(**{**home, joint: angle})
                stops += [(now + ramp, turned), (now + 2 * ramp, start)]
                ends += [now + ramp, now + 2 * ramp]
                now += 2 * ramp
        watched = between([(end, end) for end in ends], samples, dt) if self.watches else None
        return Plan(through(stops, samples, dt), watched=watched)


@dataclass(frozen=True, kw_only=True)
class RangeOfMotion(TransitionCurves):
    """Each joint is swept three times through at least 90 % of its range; the other one stays.

    Attributes:
        end: Least and greatest share of the measured range at which a sweep ends, drawn for each.
    """

    ramp_time: tuple[float, float] = setting((4.1, 5.1), "s", SHORTEST_MOVE, LONGEST)
    end: tuple[float, float] = setting((0.9, 1.0), "of the range", 0, 1)

    source: ClassVar[str] = (
        "Matty 2010 (NTRS 20100017776); ranges of Li et al. 2022; times, home and ends assumed"
    )

    def turns(self, joint: str, rng: np.random.Generator) -> Sequence[float]:
        """Returns the ends of three sweeps [rad]."""
        return [_share(joint, rng.uniform(*self.end)) for _ in range(TRIES)]


def _share(joint: str, share: float) -> float:
    """Returns the angle at a share of a joint's measured range [rad]."""
    low, high = LI_RANGES[joint]
    return low + share * (high - low)


TRANSITION_CURVES = TransitionCurves(
    name="TransitionCurves", duration=42.0, tracking=0.02, effort=SUSTAINED
)
"""The published families of curves, followed to 20 mrad."""

RANGE_OF_MOTION = RangeOfMotion(
    name="RangeOfMotion", duration=60.0, tracking=0.1, effort=SUSTAINED, hand_error=0.03
)
"""Shoulder and elbow from end to end of their ranges; the hand within 3 cm at the ends."""
