"""Why a motion did not go well: each limit of success that it exceeded, by how much and when.

A tracking error oscillates if it swings with a period which the intended motion does not have.
What the intended motion explains is subtracted first, by least squares: a mean, a drift, and what
is proportional to the intended angles, rates, accelerations and directions, as the error of an arm
with spring, damping, inertia and friction is. The rest oscillates if most of the squared error is
in one octave of its periodogram. An octave, since the period of a limit cycle with friction varies
with its amplitude.
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
SHORTEST = 6  # control periods; a wider octave at the end of the spectrum would be noise
STILL = 1e-3  # rad/s, rate below which the intended motion has no direction
SAME = 0.8  # correlation from which the intended motion repeats itself
NEAR = 0.03  # relative difference of two periods that count as the same


@dataclass(frozen=True)
class Oscillation:
    """An oscillation.

    Attributes:
        period_s: Period, the mean one if it varies [s].
        amplitude: Amplitude of a sine with the same mean square, in the unit of the error.
    """

    period_s: float
    amplitude: float


@dataclass(frozen=True)
class Reason:
    """A limit of success that a motion exceeded.

    Attributes:
        name: Name of the cost, as in `Limit`.
        value: Cost of the motion.
        limit: Greatest cost with which it would have succeeded.
        unit: Unit of both, "1" for a ratio.
        time_s: Time at which it was first exceeded [s]. A root mean square is that of the whole
            motion: its time is that from which nothing could have kept it below the limit.
        part: Joint, motor or cuff that exceeded it; None where the whole hand did.
        oscillation: Oscillation that dominates the tracking error of the joint, with its amplitude
            in `unit`; None where there is none, and for other costs.
    """

    name: str
    value: float
    limit: float
    unit: str
    time_s: float
    part: str | None
    oscillation: Oscillation | None = None


def reasons(measured: Array, costs: Array, task: Task, *, lost: bool) -> tuple[Reason, ...]:
    """Returns why a motion failed; nothing if it succeeded.

    Args:
        measured: Measurements after each control period, shape (n, columns) as `COLUMNS`.
        costs: Costs of the episode after each control period, shape (n, 14).
        task: The task.
        lost: Whether the arm was lost at the end.
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
    """A limit that some motions exceeded, with the medians of their numbers.

    The part is the most frequent one; the oscillation is there if more than half oscillate.

    Attributes:
        motions: Number of motions that exceeded it.
    """

    motions: int


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
    """Returns the oscillation that dominates an error; None where none does.

    It has at least the share `SHARE` of the squared error, a constant one included, in one octave
    with at least `PERIODS` periods in the motion. Noise, white or filtered, and drift have less. A
    period after which the intended motion is the same or the opposite, or moves again, does not
    count.

    Args:
        error: Tracking error of a joint after each control period [rad], shape (n,).
        intended: Intended angles of all joints [rad], shape (n, joints), since joints that move
            disturb the others.
        dt: Control period [s].
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
        later = np.logical_or.accumulate(same < 0)  # before, it is the same move
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
