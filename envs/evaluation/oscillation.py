"""Oscillation: a tracking error that repeats itself with a period which the motion does not have.

What the intended motion explains is subtracted first, by least squares: a mean, a drift, and what
is proportional to the intended angles, rates, accelerations and directions, as the error of
an arm with spring, damping, inertia and friction is. The rest oscillates if its autocorrelation has
a valley and then a peak. The autocorrelation at the peak is the share of the rest that is there
again one period later (Box, Jenkins, Reinsel and Ljung 2015, Time Series Analysis, ch. 2).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate, find_peaks

from ...arrays import Array

PERIODS = 5  # fewest periods in a motion; drift and slow noise seem to have fewer
REPEATED = 0.5  # least share of the squared error that repeats itself
SAME = 0.8  # correlation from which the intended motion repeats itself
NEAR = 0.9  # share of the highest peak from which an earlier one is that of the period
STILL = 1e-3  # rad/s, rate below which the intended motion has no direction


@dataclass(frozen=True)
class Oscillation:
    """An oscillation.

    Attributes:
        period_s: Period [s].
        amplitude: Amplitude of a sine whose mean square is that of what repeats itself, in the
            unit of the error.
    """

    period_s: float
    amplitude: float


def oscillation(error: Array, intended: Array, dt: float) -> Oscillation | None:
    """Returns the oscillation that dominates an error; None where none does.

    Peak and valley of the rest's autocovariance, over the mean squared error, must both be at least
    `REPEATED`: half of what is limited is there again one period later, and opposite in between.
    Drift and noise, white or filtered, stay below that. A period after which the intended motion is
    the same or the opposite, or moves again, does not count.

    Args:
        error: Tracking error of a joint after each control period [rad], shape (n,).
        intended: Intended angles of all joints [rad], shape (n, joints), since joints that move
            disturb the others.
        dt: Control period [s].
    """
    most = len(error) // PERIODS  # longest period, in samples
    if most < 3:
        return None
    rates = np.gradient(intended, dt, axis=0)
    rest, square = error - _explained(error, intended, rates, dt), np.mean(error**2)
    if np.var(rest) < REPEATED * square or square == 0:
        return None
    repeated = _autocovariance(rest, most) / square
    peaks, _ = find_peaks(repeated, height=REPEATED, prominence=REPEATED)
    peaks = peaks[~_of_intended(rates, most)[peaks]]
    if peaks.size == 0:
        return None
    at = peaks[repeated[peaks] >= NEAR * repeated[peaks].max()][0]  # two periods repeat, too
    if repeated[:at].min() > -REPEATED:
        return None
    return Oscillation(float(at * dt), float(np.sqrt(2 * repeated[at] * square)))


def _autocovariance(values: Array, most: int) -> Array:
    """Returns the mean products of values with those of some samples later, shape (most,)."""
    products = correlate(values, values, method="fft")[len(values) - 1 :][:most]
    return products / (len(values) - np.arange(most))


def _of_intended(rates: Array, most: int) -> NDArray[np.bool_]:
    """Returns the times after which an intended motion or its moves repeat, shape (most,)."""
    found = np.zeros(most, np.bool_)
    moves = (np.abs(rates) > STILL).astype(float)
    for course in (*(rates * moves).T, *(moves - moves.mean(axis=0)).T):
        same = _autocovariance(course, most)
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
