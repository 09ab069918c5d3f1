"""Reasons why a motion failed: each limit of success that was exceeded, by how much and when.

A tracking error oscillates if it has a period which the intended motion does not have. The part
that the intended motion explains is subtracted first, by least squares: a mean, a drift, and terms
in proportion to the intended angles, rates, accelerations and directions, as in the error of an arm
with spring, damping, inertia and friction. The rest oscillates if most of the squared error is in
one octave of its periodogram; an octave, since the period of a limit cycle with friction varies
with the amplitude.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate, periodogram

from ...arrays import Array
from ...assets import JOINTS
from ..interface.reward import COSTS, JOINT, LIMITS, STRAIN, WIDTH, failed
from ..model import ASSISTED
from ..model.cuffs import CUFFS
from ..simulation.measurements import COLUMNS
from ..tasks import Task

SHARE = 0.6  # least share of the squared error in one octave; see tests/envs/evaluation
PERIODS = 8  # fewest periods in a motion; drift and slow noise seem to have fewer
SHORTEST = 6  # [control periods], least period; faster octaves have much noise
STILL = 1e-3  # [rad/s], rate below which the intended motion has no direction
SAME = 0.8  # least correlation of an intended motion that repeats
NEAR = 0.03  # greatest relative difference of two periods that count as equal


@dataclass(frozen=True)
class Oscillation:
    """An oscillation."""

    period_s: float  # period, or mean period [s]
    amplitude: float  # of a sine with the same mean square, in the unit of the error


@dataclass(frozen=True)
class Reason:
    """A limit of success that a motion exceeded.

    A root mean square over the whole motion is known before its end to exceed a limit: `time_s` is
    the first time at which no later error could keep it below the limit.
    """

    name: str  # name of the cost, as in `Limit`
    value: float  # cost of the motion
    limit: float  # greatest cost of a success
    unit: str  # unit of value and limit, "1" for a ratio
    time_s: float  # first time at which the cost exceeded the limit [s]
    part: str | None  # joint, motor or cuff with the excess; None for the hand
    oscillation: Oscillation | None = None  # of the joint's tracking error, in `unit`


def reasons(measured: Array, costs: Array, task: Task, *, lost: bool) -> tuple[Reason, ...]:
    """Returns the reasons why a motion failed; none if the motion succeeded.

    Measurements (n, columns as `COLUMNS`) and costs of the episode (n, 14) are after each control
    period; `lost` says whether the arm was lost at the end.
    """
    found, times = [], measured[:, COLUMNS["time"].start]
    for limit in failed(costs[-1], len(costs), task, ended=lost):
        course = _course(limit.name, costs)
        at = int(np.argmax(~(course <= limit.value)))
        part, swing = _part(limit.name, measured, costs, at), None
        if limit.name == "worst_joint" and part is not None and len(measured) > 1:
            angle, intended = (measured[:, COLUMNS[name]] for name in ("angle", "target_angle"))
            error = (angle - intended)[:, JOINTS.index(part)]
            swing = oscillation(error, intended, float(times[1] - times[0]))
        sizes = float(course[-1]), limit.value, limit.unit, float(times[at])
        found.append(Reason(limit.name, *sizes, part, swing))
    return tuple(found)


def _course(cost: str, costs: Array) -> Array:
    """Returns a cost after each control period, shape (n,); means are over the whole motion."""
    if cost == "lost":
        return np.arange(len(costs)) == len(costs) - 1
    if cost in ("effort", "worst_joint"):
        columns = costs[:, [STRAIN]] if cost == "effort" else costs[:, JOINT:WIDTH]
        return np.sqrt(columns / len(costs)).max(axis=1)
    return costs[:, COSTS.index(cost)]


def _part(cost: str, measured: Array, costs: Array, at: int) -> str | None:
    """Returns the joint, motor or cuff that exceeds a limit at a control period."""
    names, now = JOINTS, {name: measured[at, place] for name, place in COLUMNS.items()}
    if cost == "worst_joint":
        sizes = costs[-1, JOINT:WIDTH]
    elif cost == "effort":
        sizes = np.square(measured[:, COLUMNS["effort"]]).mean(axis=0)
    elif cost == "lost":
        sizes = np.abs(now["angle"] - now["target_angle"])
    elif cost == "heat":
        names, sizes = ASSISTED, now["motor_load"]
    elif cost == "cuff_force":
        force = np.linalg.norm(now["cuff_force"].reshape(3, 3), axis=1)
        names, sizes = tuple(CUFFS), force / LIMITS
    else:
        return None
    return names[int(np.argmax(sizes))]


@dataclass(frozen=True, kw_only=True)
class Frequent(Reason):
    """A limit that some motions exceeded, with medians over these motions.

    The part is the most frequent one; the oscillation is None unless more than half oscillate.
    """

    motions: int  # number of motions that exceeded the limit


def most_frequent(why: Sequence[Sequence[Reason]]) -> tuple[Frequent, ...]:
    """Returns the limits that motions exceeded by their reasons, the most frequent one first."""
    by_name: dict[str, list[Reason]] = {}
    for one in (reason for motion in why for reason in motion):
        by_name.setdefault(one.name, []).append(one)
    found = []
    for same in by_name.values():
        value, time = np.median([(one.value, one.time_s) for one in same], axis=0)
        parts = [one.part for one in same]
        swings = [one.oscillation for one in same if one.oscillation is not None]
        swing = None
        if 2 * len(swings) > len(same):
            pairs = [(one.period_s, one.amplitude) for one in swings]
            swing = Oscillation(*map(float, np.median(pairs, axis=0)))
        common = {**vars(same[0]), "value": float(value), "time_s": float(time)}
        common |= {"part": max(parts, key=parts.count), "oscillation": swing}
        found.append(Frequent(**common, motions=len(same)))
    return tuple(sorted(found, key=lambda one: -one.motions))


def oscillation(error: Array, intended: Array, dt: float) -> Oscillation | None:
    """Returns the oscillation that dominates a joint's tracking error [rad], (n,); None if none.

    The oscillation has at least the share `SHARE` of the squared error, constant part included, in
    one octave with at least `PERIODS` periods in the motion. Noise, white or filtered, and drift
    have less. A period after which the intended motion is the same or the opposite, or moves again,
    does not count. Intended angles [rad] are of all joints, (n, joints), since moving joints
    disturb the others.
    """
    most = len(error) // PERIODS  # longest period, in samples
    if most <= SHORTEST:
        return None
    rates = np.gradient(intended, dt, axis=0)
    rest, square = error - _explained(error, intended, rates, dt), np.mean(error**2)
    frequencies, powers = periodogram(rest, 1 / dt, scaling="spectrum")
    below = np.concatenate([[0.0], np.cumsum(powers)])
    first = np.searchsorted(frequencies, frequencies / np.sqrt(2))
    end = np.searchsorted(frequencies, frequencies * np.sqrt(2), side="right")
    periods = 1 / np.maximum(frequencies, frequencies[1] / 2)
    inside = (periods <= most * dt) & (periods >= SHORTEST * dt)
    in_octave = np.where(inside, below[end] - below[first], 0.0)
    at = int(np.argmax(in_octave))
    if square == 0 or in_octave[at] < SHARE * square:
        return None
    octave = slice(first[at], end[at])
    period = 1 / np.average(frequencies[octave], weights=powers[octave])
    low, high = (round(factor * period / dt) for factor in (1 - NEAR, 1 + NEAR))
    if _of_intended(rates, most)[low : high + 1].any():
        return None
    return Oscillation(float(period), float(np.sqrt(2 * in_octave[at])))


def _of_intended(rates: Array, most: int) -> NDArray[np.bool_]:
    """Returns the times after which an intended motion or its moves repeat, shape (most + 1,)."""
    n, found = len(rates), np.zeros(most + 1, np.bool_)
    moves = (np.abs(rates) > STILL).astype(float)
    for course in (*(rates * moves).T, *(moves - moves.mean(axis=0)).T):
        same = correlate(course, course, method="fft")[n - 1 :][: most + 1]
        same /= n - np.arange(most + 1)
        later = np.logical_or.accumulate(same < 0)  # smaller shifts are within one move
        found |= later & (np.abs(same) >= SAME * same[0])
    return found


def _explained(error: Array, intended: Array, rates: Array, dt: float) -> Array:
    """Returns the part of an error that follows from drift and the intended motion."""
    directions = np.where(np.abs(rates) > STILL, np.sign(rates), 0.0)
    drift = np.vander(np.linspace(-1, 1, len(error)), 2)
    motion = [intended - intended.mean(axis=0), rates, np.gradient(rates, dt, axis=0), directions]
    causes = np.hstack([drift, *motion])
    causes = causes[:, np.abs(causes).max(axis=0) > 0]
    causes /= np.linalg.norm(causes, axis=0)
    return causes @ np.linalg.lstsq(causes, error)[0]
