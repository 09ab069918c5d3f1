"""Splits measured angle-torque records into branches, between the reversals of the angle.

A record is two series in the order of measurement: angle [rad] and torque [N·m]. No function uses
the time, but the estimate of noise needs samples at about even times.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import Array
from ..errors import InputError
from .protocol import finite_series

NOISE_DEAD_BAND = 10.0  # standard deviations, which 1 in 1e4 dwells of 1e4 samples exceeds
STEP_DEAD_BAND = 2.5  # readings: a coarse sensor that flickers over three readings has not turned
LARGEST_DEAD_BAND = 0.25  # share of the angle's range, for a few samples per branch
LARGEST = 1e100  # largest measured number: squares and products stay finite


@dataclass(frozen=True, eq=False, kw_only=True)
class Branch:
    """The part of a record between two reversals; neighbors share the sample at the turn.

    Attributes:
        direction: Sign of the motion: +1 for rising angles, -1 for falling angles.
        start: Index of the first sample in the record.
        stop: Index after the last sample, so that record[start:stop] is the branch.
        angle: Angles as measured [rad], shape (n,); jitter and dwell included.
        torque: Torques as measured [N·m], shape (n,).
    """

    direction: int
    start: int
    stop: int
    angle: Array
    torque: Array


def angle_noise(angle: ArrayLike) -> float:
    """Estimates the standard deviation of white noise in a measured motion [rad].

    The estimate is the median of |third differences| of the angle without repeated readings. Third
    differences are sqrt(20) times as noisy as the angle, and nearly zero for a smooth motion. A
    low-pass filter hides the noise of its input from this estimate.
    """
    third = np.diff(_without_repeats(_measured("angle", angle, "rad")), 3)
    return float(np.median(np.abs(third))) / (0.6745 * math.sqrt(20)) if third.size else 0.0


def estimate_dead_band(angle: ArrayLike) -> float:
    """Estimates the dead band [rad], the least return that counts as a reversal, from the noise.

    This is 10 times `angle_noise`, at least 2.5 times the smallest step (the resolution of a coarse
    sensor), and at most a quarter of the angle's range. For filtered angles, choose the dead band
    yourself: a filter hides their noise from the estimate.
    """
    angle = _measured("angle", angle, "rad")
    steps = np.abs(np.diff(_without_repeats(angle)))
    step = float(steps.min()) if steps.size else 0.0
    dead_band = max(NOISE_DEAD_BAND * angle_noise(angle), STEP_DEAD_BAND * step)
    return min(dead_band, LARGEST_DEAD_BAND * float(np.ptp(angle)))


def reversals(angle: ArrayLike, dead_band: float | None = None) -> NDArray[np.intp]:
    """Finds the turning points of a noisy motion.

    An extreme angle is a turning point if the motion comes back from there by more than the dead
    band. If the noise stays within half the dead band, and each true swing is larger than twice the
    dead band, then exactly the true reversals are found.

    Args:
        angle: Joint angles [rad], shape (n,).
        dead_band: Distance by which the motion comes back from a turning point [rad], >= 0; None
            takes `estimate_dead_band`.

    Returns:
        Ascending indices of the turning points, without the two ends of the record. A dwell at an
        extreme gives the first sample of the dwell.
    """
    angle = _measured("angle", angle, "rad")
    turns, _ = _turning_points(angle, _dead_band(angle, dead_band))
    return np.array(turns, dtype=np.intp)


def branches(angle: ArrayLike, torque: ArrayLike, dead_band: float | None = None) -> list[Branch]:
    """Splits a record at its reversals.

    Args:
        angle: Joint angles [rad], shape (n,), n >= 3.
        torque: Torques [N·m], shape (n,).
        dead_band: Dead band of `reversals` [rad].

    Returns:
        The branches in the order of measurement, with alternating directions.
    """
    angle, torque = finite_record(angle, torque)
    dead_band = _dead_band(angle, dead_band)
    turns, direction = _turning_points(angle, dead_band)
    if direction == 0:
        raise InputError(
            f"the angle stays within {np.ptp(angle):.3g} rad and the dead band is {dead_band:.3g} "
            "rad: record a larger motion, or give a smaller dead_band"
        )
    ends = list(pairwise([0, *turns, angle.size - 1]))
    return [
        Branch(
            direction=direction * (-1) ** (len(turns) - i),
            start=start,
            stop=end + 1,
            angle=angle[start : end + 1],
            torque=torque[start : end + 1],
        )
        for i, (start, end) in enumerate(ends)
    ]


def finite_record(angle: ArrayLike, torque: ArrayLike) -> tuple[Array, Array]:
    """Returns both series as arrays of one size, at least 3."""
    angle, torque = _measured("angle", angle, "rad"), _measured("torque", torque, "N·m")
    if angle.size != torque.size:
        raise InputError(
            f"angle has {angle.size} samples and torque has {torque.size}: give as many of both"
        )
    if angle.size < 3:
        raise InputError(f"the record has {angle.size} samples: a reversal takes at least 3")
    return angle, torque


def _measured(name: str, values: ArrayLike, unit: str) -> Array:
    series = finite_series(name, values, unit)
    largest = int(np.argmax(np.abs(series)))
    if abs(series[largest]) > LARGEST:
        raise InputError(
            f"{name}[{largest}] is {series[largest]:.3g}: give numbers of at most {LARGEST:g} "
            f"({unit})"
        )
    return series


def _without_repeats(angle: Array) -> Array:
    return angle[np.diff(angle, prepend=np.nan) != 0]


def _dead_band(angle: Array, dead_band: float | None) -> float:
    if dead_band is None:
        return estimate_dead_band(angle)
    if not (math.isfinite(dead_band) and dead_band >= 0):
        raise InputError(f"dead_band is {dead_band}: give a finite number, at least 0 (rad)")
    return float(dead_band)


def _turning_points(angle: Array, dead_band: float) -> tuple[list[int], int]:
    """Returns the indices of the turns and the last direction, 0 within the dead band."""
    turns: list[int] = []
    direction = lowest_at = highest_at = 0
    lowest = highest = float(angle[0])
    for i, value in enumerate(angle.tolist()):
        if value > highest:
            highest, highest_at = value, i
        if value < lowest:
            lowest, lowest_at = value, i
        if direction >= 0 and highest - value > dead_band:
            if direction:
                turns.append(highest_at)
            direction, lowest, lowest_at = -1, value, i
        elif direction <= 0 and value - lowest > dead_band:
            if direction:
                turns.append(lowest_at)
            direction, highest, highest_at = 1, value, i
    return turns, direction
