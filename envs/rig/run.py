"""Runs the measuring rig: a motor slowly turns one joint of an empty pressurized suit.

A torque sensor sits between motor and joint, and an encoder on the joint. The sensor reads more
than the suit's resistance, which is compensated as an experimenter would do it: a run without the
suit shows the inertia and the friction of the bearings, and the torque that they need along the
planned motion is subtracted. The axis is vertical, so that weight has no moment.
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
from ...assets import FOLDER
from ...errors import InputError
from ...hysteresis.engine import attach, fault_slots
from ...hysteresis.protocol import finite_series
from ..provenance import Quantity
from .config import SAME, RigConfig, Specimen, reversals

Indices = NDArray[np.int64]

RIG = FOLDER / "mjcf" / "rig.xml"
JOINT = "joint"
STEP = 0.001  # s; the torsion bar of rig.xml oscillates by a quarter of a radian meanwhile
RAMP = 0.5  # [s], time from rest to full rate
DWELL = 0.5  # [s], rest before each curve
PATIENCE = 3600.0  # s, the longest curve
ZEROING = 50  # readings without the suit before each curve, whose mean is the sensor's zero

PROVENANCE: tuple[Quantity, ...] = (
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
    """One measured curve."""

    name: str  # name of the curve
    time: Array  # time since the beginning of the curve [s], shape (n,)
    angle: Array  # angle that the encoder read [rad], shape (n,)
    # Resistance, positive against positive motion [N·m], shape (n,): the reading of the torque
    # sensor, less the torque that inertia and bearings need.
    torque: Array


def run_rig(config: RigConfig, motions: Mapping[str, ArrayLike] | None = None) -> list[Record]:
    """Measures first-order curves, or any other motions, on the simulated rig.

    Before each curve the torque sensor is zeroed without the suit, and the suit's memory begins
    again at the start angle: with zero torque, unless the suit's file says otherwise. A suit need
    not be certified, as long as its torque stays finite.

    Args:
        config: Configuration of the rig.
        motions: Angles [rad], shape (n,), by the name of their curve, in place of those of the
            configuration. They begin at `config.start_angle`; only their reversals matter, since
            the motor goes from one to the next at its own rate.

    Returns:
        One record per curve; first-order curves are named after their turn, with two decimals, and
        the one of `config.motion` is named "motion".
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
                f"motion {name!r} begins at {series[0]:g} rad: let it begin at the start_angle, "
                f"{config.start_angle:g} rad"
            )
        turns = series[reversals(series)]
        points = [specimen.inside(f"motion {name!r}", angle) for angle in turns]
        ways[name] = Way(points, [config.rate] * (len(points) - 1))
    return ways


def _compose(config: RigConfig, specimen: Specimen | None = None) -> mujoco.MjModel:
    """Returns the rig with the specimen in it, or empty."""
    spec = mujoco.MjSpec.from_file(str(RIG))
    spec.option.timestep = STEP
    spec.joint(JOINT).frictionloss = config.bearing_friction
    if specimen:
        start = {"start_angle": config.start_angle, "start_torque": specimen.start_torque}
        attach(spec, JOINT, specimen.model, **start, sensors=False, allow_uncertified=True)
    return spec.compile()


def _own_torque(config: RigConfig, plan: Plan, rng: np.random.Generator) -> Array:
    """Returns the coefficients of `_causes` that a run of the empty rig shows."""
    now = _samples(config, plan)
    _, torque = _readings(config, _compose(config), "without the suit", plan, rng)
    # Time is a cause here, so that a drift of the sensor is not taken for friction.
    causes = np.column_stack([_causes(plan, now), now])
    return np.linalg.lstsq(causes, torque)[0][:-1].astype(np.float64)


def _causes(plan: Plan, now: Indices) -> Array:
    """Returns the causes of the rig's own torque, acceleration and friction, shape (n, 2)."""
    return np.column_stack([plan.acceleration[now], np.sign(plan.rate[now])])


def _samples(config: RigConfig, plan: Plan) -> Indices:
    """Returns the steps of a plan at which the sensors are read."""
    steps = np.arange(0, plan.angle.size - 1, 1 / (config.sample_rate * STEP))
    return np.round(steps).astype(np.int64)


def _readings(
    config: RigConfig, rig: mujoco.MjModel, name: str, plan: Plan, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Returns encoder angles [rad] and sensor torques [N·m] of a motion, shape (n,) each."""
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
    """Plans a motion through reversals, from rest to rest; short branches miss their rate."""
    rest = np.array([[way.points[0]], [0.0], [0.0]])
    branches = (_branch(*branch, time_step) for branch in _branches(way))
    return Plan(*np.concatenate([rest, *branches], axis=1))


def duration(way: Way) -> float:
    """Returns the duration of such a motion [s]."""
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
