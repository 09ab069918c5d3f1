"""The motion of the rig's motor: constant rate between reversals, with short ramps."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ..provenance import Quantity

RAMP = 0.5  # [s], time from rest to full rate

PROVENANCE: tuple[Quantity, ...] = (
    Quantity("rig.ramp", RAMP, "s", "long beside the servo's time constant of 0.01 s", "assumed"),
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


def plan_motion(way: Way, time_step: float) -> Plan:
    """Plans a motion through its reversals; it begins and ends at rest.

    Args:
        way: Reversals, and the rates between them; a short branch does not reach its rate.
        time_step: Time between two steps [s].
    """
    rest = np.array([[way.points[0]], [0.0], [0.0]])
    branches = (_branch(*branch, time_step) for branch in _branches(way))
    return Plan(*np.concatenate([rest, *branches], axis=1))


def duration(way: Way) -> float:
    """Returns the duration of such a motion [s]."""
    return sum(
        abs(end - start) / _top(start, end, rate) + RAMP for start, end, rate in _branches(way)
    )


def reversals(angle: Array) -> NDArray[np.intp]:
    """Returns the indices of the first angle, of those where the motion turns, and of the last."""
    moving = np.flatnonzero(np.append(True, np.diff(angle) != 0))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(angle[moving])))) + 1
    return np.array([0, *moving[turns], moving[-1]])


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
