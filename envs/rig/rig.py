"""The measuring rig: a motor slowly turns one joint of an empty pressurized suit.

A torque sensor sits between motor and joint, and an encoder on the joint. The sensor reads more
than the resistance of the suit. The rest is compensated as an experimenter would do it: a run
without the suit shows the inertia and the friction of the bearings, and the torque that inertia and
friction need along the planned motion is subtracted. The axis is vertical, so that weight has no
moment.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arrays import Array
from ...assets import FOLDER, AnySuit, SuitJoint, load_suit
from ...checks import at_least, check_seed, number, numbers
from ...errors import InputError, shown, unknown_name
from ...hysteresis import HysteresisModel
from ...hysteresis.engine import attach, fault_slots
from ...hysteresis.protocol import finite_series
from ...published import LI_TURNS
from ..provenance import Quantity, check_settings, quantities_of, setting

Indices = NDArray[np.int64]

RIG = FOLDER / "mjcf" / "rig.xml"
JOINT = "joint"
STEP = 0.001  # s; the torsion bar of rig.xml oscillates by a quarter of a radian meanwhile
RAMP = 0.5  # [s], time from rest to full rate
DWELL = 0.5  # [s], rest before each curve
PATIENCE = 3600.0  # s, the longest curve
ZEROING = 50  # readings without the suit before each curve, whose mean is the sensor's zero
TURNS = {f"{joint}_flexion": turns for joint, turns in LI_TURNS.items()}  # rad
LEAST_TRAVEL = 0.01  # rad; curves are named after their turn with two decimals
SAME = 1e-6  # [rad], greatest distance of two angles that count as equal
ROUNDING = 1e-3  # share of a rate by which rounding in a file may change the rate
FULL_TURN = 2 * math.pi  # rad
RATE, RATE_RANGE = 0.1, (0.01, 0.5)  # rad/s
SAMPLE_RATE = 25.0  # Hz
NOISE = 0.05  # N·m
LARGEST = 1000.0  # N·m, N·m/s
FINEST = 1e-12  # N·m, rad


def reversals(angle: Array) -> NDArray[np.intp]:
    """Returns the indices of the first angle, of the turns of the motion, and of the last angle."""
    moving = np.flatnonzero(np.append(True, np.diff(angle) != 0))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle[moving])))) + 1
    return np.array([0, *moving[turns], moving[-1]])


class Specimen(NamedTuple):
    """The joint in the rig: model, start of its memory [rad, N·m], and range [rad]."""

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
        start_angle: Angle at which all curves begin [rad]; by default the angle at which the suit's
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
            pair for each sample. The motion has rates of its own: only its reversals and the mean
            rate of each branch between two reversals matter, and only these are kept. `start_angle`
            is by default the angle of the first pair.
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
        """Angle at which all curves begin [rad]."""
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
    """Checks that the motor can go from each turn (time [s], angle [rad]) to the next turn."""
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
    Quantity("rig.ramp", RAMP, "s", "long beside the servo's time constant of 0.01 s", "assumed"),
    Quantity("rig.dwell", DWELL, "s", "longer than the servo takes to settle", "assumed"),
    Quantity("rig.zeroing", ZEROING, "1", "makes the zero 7 times as sure as a reading", "assumed"),
)


class Plan(NamedTuple):
    """The planned motion of the motor: angle [rad], rate and acceleration per step, (n,) each."""

    angle: Array
    rate: Array
    acceleration: Array


class Way(NamedTuple):
    """First angle, reversals and last angle [rad], and the rate of each branch [rad/s]."""

    points: Sequence[float]
    rates: Sequence[float]


@dataclass(frozen=True, eq=False)
class Record:
    """One measured curve.

    Attributes:
        name: Name of the curve.
        time: Time since the beginning of the curve [s], shape (n,).
        angle: Angle that the encoder read [rad], shape (n,).
        torque: Resistance, positive against positive motion [N·m], shape (n,): the reading of the
            torque sensor, less the torque that inertia and bearings need.
    """

    name: str
    time: Array
    angle: Array
    torque: Array


def run_rig(config: RigConfig, motions: Mapping[str, ArrayLike] | None = None) -> list[Record]:
    """Measures first-order curves, or any other motions, on the simulated rig.

    Before each curve the torque sensor is zeroed without the suit, and the suit's memory begins
    again at the start angle: with zero torque, unless the suit's file says otherwise. A suit need
    not be certified, as long as its torque stays finite.

    Args:
        config: Configuration of the rig.
        motions: Angles [rad], shape (n,), by the name of their curve, in place of the motions of
            the configuration. Each motion begins at `config.start_angle`. Only its reversals
            matter, since the motor goes from one reversal to the next at its own rate.

    Returns:
        One record per curve. First-order curves are named after their turn, with two decimals, and
        the curve of `config.motion` is named "motion".
    """
    specimen = config.specimen()
    ways = _curves(config) if motions is None else _motions(config, specimen, motions)
    if not ways:
        raise InputError("there is no motion: give turns (rad), or motions by name")
    times = {name: duration(way) for name, way in ways.items()}
    longest = max(times, key=times.__getitem__)
    if times[longest] > PATIENCE:
        raise InputError(
            f"curve {longest!r} takes {times[longest]:.0f} s: stay within {PATIENCE:.0f} s with a "
            "higher rate or fewer reversals"
        )
    rng = np.random.default_rng(config.seed)
    own_torque = _own_torque(config, plan_motion(ways[longest], STEP), rng)
    rig = _compose(config, specimen)
    records = []
    for name, way in ways.items():
        plan = plan_motion(way, STEP)
        now = _samples(config, plan)
        angle, torque = _readings(config, rig, name, plan, rng)
        torque -= _causes(plan, now) @ own_torque
        records.append(Record(name, STEP * now.astype(np.float64), angle, torque))
    return records


def _curves(config: RigConfig) -> dict[str, Way]:
    if config.motion:
        pairs = np.array(config.motion)
        time, angle = pairs[:, 0], pairs[:, 1]
        return {"motion": Way(angle.tolist(), np.abs(np.diff(angle) / np.diff(time)).tolist())}
    start, rates = config.start, [config.rate] * 2 * config.repeats
    return {
        f"{turn:.2f}": Way([start, *[turn, start] * config.repeats], rates) for turn in config.turns
    }


def _motions(
    config: RigConfig, specimen: Specimen, motions: Mapping[str, ArrayLike]
) -> dict[str, Way]:
    """Returns the checked reversals of motions."""
    ways = {}
    for name, angles in motions.items():
        series = finite_series(f"motion {name!r}", angles, "rad")
        if np.ptp(series) == 0:
            raise InputError(f"motion {name!r} stays at {series[0]:g} rad: let it move")
        if abs(series[0] - config.start) > SAME:
            raise InputError(
                f"motion {name!r} begins at {series[0]:g} rad: begin at the start_angle, "
                f"{config.start_angle:g} rad"
            )
        turns = series[reversals(series)]
        points = [specimen.inside(f"motion {name!r}", angle) for angle in turns]
        ways[name] = Way(points, [config.rate] * (len(points) - 1))
    return ways


def _compose(config: RigConfig, specimen: Specimen | None = None) -> mujoco.MjModel:
    """Returns the rig with the specimen, or the empty rig."""
    spec = mujoco.MjSpec.from_file(str(RIG))
    spec.option.timestep = STEP
    spec.joint(JOINT).frictionloss = config.bearing_friction
    if specimen:
        start = {"start_angle": config.start_angle, "start_torque": specimen.start_torque}
        attach(spec, JOINT, specimen.model, **start, sensors=False, allow_uncertified=True)
    return spec.compile()


def _own_torque(config: RigConfig, plan: Plan, rng: np.random.Generator) -> Array:
    """Returns the coefficients of `_causes`, from a run of the empty rig."""
    now = _samples(config, plan)
    _, torque = _readings(config, _compose(config), "without the suit", plan, rng)
    # Time is a third cause here, so that a drift of the sensor does not count as friction.
    causes = np.column_stack([_causes(plan, now), now])
    return np.linalg.lstsq(causes, torque)[0][:-1].astype(np.float64)


def _causes(plan: Plan, now: Indices) -> Array:
    """Returns acceleration and direction, which cause the rig's own torque, shape (n, 2)."""
    return np.column_stack([plan.acceleration[now], np.sign(plan.rate[now])])


def _samples(config: RigConfig, plan: Plan) -> Indices:
    """Returns the steps of a plan at which the sensors are read."""
    steps = np.arange(0, plan.angle.size - 1, 1 / (config.sample_rate * STEP))
    return np.round(steps).astype(np.int64)


def _readings(
    config: RigConfig, rig: mujoco.MjModel, name: str, plan: Plan, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Returns the readings of encoder [rad] and torque sensor [N·m], shape (n,) each."""
    now = _samples(config, plan)
    twist, angle = _move(config, rig, name, plan)[now].T
    torque = rig.tendon_stiffness[0] * twist + config.drift * STEP * now
    noise = config.noise * rng.standard_normal(ZEROING + torque.size)
    read = _rounded(np.append(np.zeros(ZEROING), torque) + noise, config.torque_resolution)
    return _rounded(angle, config.angle_resolution), read[ZEROING:] - read[:ZEROING].mean()


def _move(config: RigConfig, rig: mujoco.MjModel, name: str, plan: Plan) -> Array:
    """Returns twist and angle of the joint [rad] at each step of a plan, shape (n, 2)."""
    data = mujoco.MjData(rig)
    data.qpos[:] = config.start
    command, sensors = data.ctrl, data.sensordata
    command[:] = config.start, 0.0
    mujoco.mj_step(rig, data, round(DWELL / STEP))
    measured = np.empty((plan.angle.size, sensors.size))
    for i, setpoint in enumerate(zip(plan.angle, plan.rate, strict=True)):
        command[:] = setpoint
        mujoco.mj_step(rig, data)  # reads the sensors, then moves
        measured[i] = sensors
    if data.plugin_state[fault_slots(rig)].any():
        raise InputError(
            f"the torque of the suit becomes infinite on curve {name!r}: its model is not "
            "certified there; give turns nearer to the start"
        )
    limit = rig.actuator_forcerange[0, 1]
    if not np.abs(measured[:, -1]).max() < limit:  # a motion that diverged is NaN
        raise InputError(
            f"the suit resists more than the {limit:g} N·m of the motor on curve {name!r}: give "
            "turns nearer to the start, or a softer suit"
        )
    return measured[:, :-1]


def _rounded(values: Array, resolution: float | None) -> Array:
    return values if resolution is None else resolution * np.round(values / resolution)


def plan_motion(way: Way, time_step: float) -> Plan:
    """Plans a motion from rest to rest; a short branch does not reach its rate."""
    rest = np.array([[way.points[0]], [0.0], [0.0]])
    branches = (_branch(*branch, time_step) for branch in _branches(way))
    return Plan(*np.concatenate([rest, *branches], axis=1))


def duration(way: Way) -> float:
    """Returns the duration of a planned motion [s]."""
    return sum(
        abs(end - start) / _top(start, end, rate) + RAMP for start, end, rate in _branches(way)
    )


def _branches(way: Way) -> Iterator[tuple[float, float, float]]:
    return ((*ends, rate) for ends, rate in zip(pairwise(way.points), way.rates, strict=True))


def _branch(start: float, end: float, rate: float, time_step: float) -> Array:
    """Returns angle, rate and acceleration of a branch without its first instant, shape (3, n).

    Rate and acceleration are continuous and vanish at both ends, so that the servo can follow.
    """
    distance = abs(end - start)
    top = _top(start, end, rate)
    total = distance / top + RAMP
    time = np.minimum(np.arange(1, math.ceil(total / time_step) + 1) * time_step, total)
    left = total - time
    speeding, braking = time < RAMP, left < RAMP
    phase = math.pi * np.minimum(np.minimum(time, left) / RAMP, 1)
    ramp_way = top * RAMP / (2 * math.pi) * (phase - np.sin(phase))
    way = np.select([speeding, braking], [ramp_way, distance - ramp_way], top * (time - RAMP / 2))
    speed = top * np.sin(phase / 2) ** 2
    acceleration = math.pi * top / (2 * RAMP) * np.sin(phase) * np.where(speeding, 1, -1)
    sign = math.copysign(1.0, end - start)
    return np.array([start + sign * way, sign * speed, sign * acceleration])


def _top(start: float, end: float, rate: float) -> float:
    return min(rate, abs(end - start) / RAMP)
