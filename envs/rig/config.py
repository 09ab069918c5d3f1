"""The configuration of the measuring rig: the joint, the motions and the device."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...assets import AnySuit, SuitJoint, load_suit
from ...checks import at_least, check_seed, number, numbers
from ...errors import InputError, shown, unknown_name
from ...hysteresis import HysteresisModel
from ...published import LI_TURNS
from ..provenance import Quantity, check_settings, quantities_of, setting

TURNS = {f"{joint}_flexion": turns for joint, turns in LI_TURNS.items()}  # rad
LEAST_TRAVEL = 0.01  # rad; curves are named after their turn with two decimals
SAME = 1e-6  # [rad], distance of two angles that are meant to be one
ROUNDING = 1e-3  # share of a rate that the digits of a file may change
FULL_TURN = 2 * math.pi  # rad
RATE, RATE_RANGE = 0.1, (0.01, 0.5)  # rad/s
SAMPLE_RATE = 25.0  # Hz
NOISE = 0.05  # N·m
LARGEST = 1000.0  # N·m, N·m/s
FINEST = 1e-12  # N·m, rad


def reversals(angle: Array) -> NDArray[np.intp]:
    """Returns the indices of the first angle, of those where the motion turns, and of the last."""
    moving = np.flatnonzero(np.append(True, np.diff(angle) != 0))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle[moving])))) + 1
    return np.array([0, *moving[turns], moving[-1]])


class Specimen(NamedTuple):
    """The joint in the rig: its model, where its memory begins [rad, N·m], its range [rad]."""

    name: str
    model: HysteresisModel
    start_angle: float = 0.0
    start_torque: float = 0.0
    range: tuple[float, float] = (-FULL_TURN, FULL_TURN)

    def inside(self, what: str, angle: float) -> float:
        """Returns the angle; raises an InputError if it is not a finite angle in the range."""
        low, high = self.range
        # The range of an identified suit ends at a sample, which may miss the turn itself.
        if not low - LEAST_TRAVEL <= number(what, angle, "rad") <= high + LEAST_TRAVEL:
            raise InputError(
                f"{what} is {angle:g} rad: give an angle in the range of {self.name}, "
                f"{low:.4g} to {high:.4g} rad"
            )
        return float(angle)


@dataclass(frozen=True, kw_only=True)
class RigConfig:
    """Motions to measure, and the device; defaults are filled in when the object is made.

    Attributes:
        suit: Name of a shipped suit or path of a suit file; or a `Suit`, a `SuitJoint`, or any
            hysteresis model.
        joint: Joint of the suit; it is ignored if `suit` is a `SuitJoint` or a model.
        turns: Angles at which the first-order curves turn back [rad]. By default those of Li et al.
            2022 for shoulder and elbow flexion, fifths of the range for other joints and for a
            `SuitJoint`, and none for a model.
        start_angle: Angle at which all curves begin [rad]; by default the one at which the suit's
            memory begins, and 0 for a model.
        repeats: Number of times that each curve goes to its turn and back. The suit's memory begins
            again before each curve, not before each repeat.
        rate: Speed of the joint between reversals [rad/s], from 0.01 to 0.5.
        sample_rate: Sampling rate of both sensors [Hz], from 1 to 1000.
        noise: Standard deviation of the torque sensor's white noise [N·m].
        drift: Drift of the torque sensor [N·m/s]; it is zeroed before each curve.
        torque_resolution: Resolution of the torque sensor [N·m]; None means no steps.
        angle_resolution: Resolution of the encoder [rad]; None means no steps.
        bearing_friction: Coulomb friction of the joint's bearings [N·m].
        seed: Seed of the noise.
        motion: Times [s] and angles [rad] of a motion to measure in place of first-order curves, a
            pair for each sample, which has then its own rates. Only its reversals and the mean rate
            of each branch between them matter, and only they are kept. `start_angle` is by default
            the angle of the first pair.
    """

    suit: AnySuit | SuitJoint | HysteresisModel = "mock-suit"
    joint: str = "elbow_flexion"
    turns: tuple[float, ...] = ()
    start_angle: float | None = None
    repeats: int = 1
    rate: float = setting(RATE, "rad/s", *RATE_RANGE, source="slow: a curve takes 10 to 20 s")
    sample_rate: float = setting(SAMPLE_RATE, "Hz", 1, 1000, source="0.004 rad between samples")
    noise: float = setting(NOISE, "N·m", 0, LARGEST, source="about 1 % of a suit's elbow torque")
    drift: float = setting(0.0, "N·m/s", -LARGEST, LARGEST)
    torque_resolution: float | None = setting(None, "N·m", FINEST, LARGEST)
    angle_resolution: float | None = setting(None, "rad", FINEST, FULL_TURN)
    bearing_friction: float = setting(0.0, "N·m", 0, LARGEST)
    seed: int = 0
    motion: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        specimen = self.specimen()
        usual = specimen.start_angle
        if np.size(self.motion):
            object.__setattr__(self, "motion", self._checked_motion(specimen))
            usual = self.motion[0][1]
        start = usual if self.start_angle is None else self.start_angle
        object.__setattr__(self, "start_angle", specimen.inside("start_angle", start))
        turns = numbers("turns", self.turns, "rad") if np.size(self.turns) else ()
        if not (turns or self.motion or isinstance(self.suit, HysteresisModel)):
            usual = None if isinstance(self.suit, SuitJoint) else TURNS.get(self.joint)
            way = specimen.range[1] - start
            turns = usual or tuple(round(start + i / 5 * way, 4) for i in range(1, 6))
        object.__setattr__(self, "turns", tuple(specimen.inside("turn", turn) for turn in turns))
        names = {f"{turn:.2f}" for turn in self.turns}
        near = any(abs(turn - start) < LEAST_TRAVEL for turn in self.turns)
        if near or len(names) < len(self.turns):
            raise InputError(
                f"turns are {', '.join(f'{turn:g}' for turn in self.turns)} rad, from {start:g} "
                f"rad: give turns that differ from the start and each other by {LEAST_TRAVEL:g} "
                "rad or more"
            )
        at_least("repeats", self.repeats, 1)
        check_seed(self.seed)
        check_settings(self, "")

    def _checked_motion(self, specimen: Specimen) -> tuple[tuple[float, float], ...]:
        for name in ("turns", "repeats", "rate"):
            given, usual = getattr(self, name), self.__dataclass_fields__[name].default
            if np.size(given) and given != usual:
                raise InputError(
                    f"{name} is {shown(given)} beside a motion, which has its own: leave {name} out"
                )
        try:
            pairs: Array = np.asarray(self.motion, dtype=np.float64)
        except (TypeError, ValueError):
            pairs = np.empty(0)
        if pairs.ndim != 2 or pairs.shape[1] != 2 or len(pairs) < 2 or not np.isfinite(pairs).all():
            raise InputError(
                f"motion is {shown(self.motion)}: give pairs of time [s] and angle [rad], at least "
                "2 of finite numbers"
            )
        time, angle = pairs[:, 0], pairs[:, 1]
        if not (np.diff(time) > 0).all():
            at = int(np.argmin(np.diff(time) > 0)) + 1
            raise InputError(
                f"motion[{at}] is at {time[at]:g} s, after one at {time[at - 1]:g} s: give times "
                "that rise"
            )
        if np.ptp(angle) == 0:
            raise InputError(f"motion stays at {angle[0]:g} rad: let it move")
        for extreme in (angle.min(), angle.max()):
            specimen.inside("an angle of motion", extreme)
        turns = pairs[reversals(angle)]
        _check_rates(turns)
        if self.start_angle is not None and abs(self.start_angle - angle[0]) > SAME:
            raise InputError(
                f"start_angle is {self.start_angle:g} rad, and the motion begins at {angle[0]:g} "
                "rad: leave start_angle out"
            )
        return tuple((now, at) for now, at in turns.tolist())

    @property
    def start(self) -> float:
        """The angle at which all curves begin [rad]."""
        assert self.start_angle is not None
        return self.start_angle

    def specimen(self) -> Specimen:
        """Returns the joint to measure."""
        if isinstance(self.suit, HysteresisModel):
            return Specimen("the model", self.suit)
        if isinstance(self.suit, SuitJoint):
            name, entry = "the joint", self.suit
        else:
            name, suit = self.joint, load_suit(self.suit)
            if name not in suit.joints:
                raise unknown_name(f"joint of suit {suit.name!r}", name, suit.joints)
            entry = suit.joints[name]
        return Specimen(name, entry.model, entry.start_angle, entry.start_torque, entry.range)


def _check_rates(turns: Array) -> None:
    """Checks that the motor can go from each turn (time [s], angle [rad]) to the next one."""
    low, high = RATE_RANGE
    way, took = np.abs(np.diff(turns[:, 1])), np.diff(turns[:, 0])
    for distance, duration, begin in zip(way, took, turns[:, 0], strict=False):
        rate = distance / duration
        if not low * (1 - ROUNDING) <= rate <= high * (1 + ROUNDING):
            raise InputError(
                f"the motion goes {distance:.3g} rad in {duration:.3g} s from {begin:g} s on, at "
                f"{rate:.3g} rad/s: give {low:g} to {high:g} rad/s"
            )


PROVENANCE: tuple[Quantity, ...] = (
    *(
        Quantity(f"rig.{joint}.turn.{i}", turn, "rad", "Li et al. 2022, 3.1 and 5.1", "published")
        for joint, turns in TURNS.items()
        for i, turn in enumerate(turns, start=1)
    ),
    *quantities_of(RigConfig, "rig"),
)
