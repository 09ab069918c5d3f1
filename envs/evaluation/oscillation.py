"""Oscillation: a tracking error that swings with a period which the intended motion does not have.

What the intended motion explains is subtracted first, by least squares: a mean, a drift, and what
is proportional to the intended angles, rates, accelerations and directions, as the error of an arm
with spring, damping, inertia and friction is. The rest oscillates if most of the squared error is
in one octave of its periodogram. An octave, since the period of a limit cycle with friction varies
with its amplitude.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate, periodogram

from ...arrays import Array

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
