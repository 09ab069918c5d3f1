"""The noise of a measured torque: white noise beside slow noise, estimated from a residual.

A sensor's noise has a white part, independent from sample to sample, and a slow part (an AR(1)
process). Their shares are estimated from the residual of a fit by restricted maximum likelihood
(Patterson and Thompson 1971, Biometrika 58, 545), because the fit has made the residual smaller.
Since no pair of shares is certain, results are averaged over a grid of pairs, weighed by their
likelihood.

The noise of some sensors is in part proportional to the torque. A residual and its columns are then
divided by the relative deviation of each sample, after which the noise is even.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.interpolate import BSpline

from ...arrays import Array
from ...hysteresis.loops import branches
from ..data.curves import Curve
from ..fits.tangent import independent

MEMORIES = (0.3, 0.5, 0.65, 0.75, 0.82, 0.88, 0.92, 0.95, 0.97, 0.98, 0.99)
SHARES = (0.0, 0.1, 0.25, 0.5, 0.75, 0.9)

GRID = np.array([(0.0, 0.0), *((memory, white) for memory in MEMORIES for white in SHARES)])
"""Correlation of slow noise from sample to sample, and share of white noise in the variance."""

SIMPLER = 10.0  # prior odds of white noise alone
AT_PEAK = np.geomspace(0.5, 50, 15)  # ratios to try of the proportional part to the constant one
OVERLAP = 1.45  # sum of correlations: so many samples, which share neighbors, count as one
TINY = 1e-3  # least distance from the neighbors over the median one, as torques may have few digits
FEWEST = 30  # samples, below which noise counts as even
PIECES = 12  # largest number of polynomial pieces of a branch
SAMPLES = 6  # least number of samples of a piece
CUBIC = 3  # degree of the pieces


class Uneven(NamedTuple):
    """How the deviation of noise depends on the torque."""

    ratio: float = 0.0  # part in proportion to the torque over the constant part [1/(N·m)]
    square: float = 1.0  # mean of 1 + (ratio * torque)^2 over the curves

    def at(self, torque: Array) -> Array:
        """Returns the deviation at torques [N·m] over its root mean square along the curves."""
        return np.sqrt((1 + (self.ratio * torque) ** 2) / self.square)


EVEN = Uneven()


@dataclass(frozen=True, eq=False)
class Noise:
    """Noise of a torque, as estimated from a residual."""

    weight: Array  # probability of each noise of the grid, (g,)
    variance: Array  # of the torque under each of them [(N·m)^2], (g,)
    freedom: int  # number of samples less that of the columns of the fit
    uneven: Uneven = EVEN  # how the deviation depends on the torque; the variance is the mean

    @property
    def deviation(self) -> float:
        """Standard deviation of the torque, root mean square along the curves [N·m]."""
        return math.sqrt(float(self.weight @ self.variance))

    @property
    def constant(self) -> float:
        """The deviation without torque [N·m]."""
        return self.deviation / math.sqrt(self.uneven.square)

    @property
    def share(self) -> float:
        """The proportional part of the deviation over the torque."""
        return self.constant * self.uneven.ratio

    @property
    def memory(self) -> float:
        """Correlation from one sample to the next."""
        slow = GRID[:, 0] * (1 - GRID[:, 1])
        return float(self.weight @ slow)

    def draw(self, torque: Array, sizes: Sequence[int], rng: np.random.Generator) -> Array:
        """Returns noise along curves [N·m], end to end, for their torque without noise [N·m].

        The memory of the noise and its share of white noise are drawn, too.
        """
        chosen = rng.choice(len(GRID), p=self.weight)
        memory, white = GRID[chosen]
        found = []
        for size in sizes:
            slow = math.sqrt(1 - white) * slow_noise(size, memory, rng)
            found.append(slow + math.sqrt(white) * rng.standard_normal(size))
        return math.sqrt(self.variance[chosen]) * self.uneven.at(torque) * np.concatenate(found)


def uneven_noise(residual: Array, torque: Array, sizes: Sequence[int]) -> Uneven:
    """Returns how noise depends on the torque, if the information criterion finds that it does.

    The distances of samples from the mean of their two neighbors are compared, which are small for
    a smooth misfit and slow noise, by their logarithms, which outliers hardly change. Residual and
    fitted torque [N·m] have the shape (samples,).
    """
    ends = np.cumsum(sizes)[:-1]
    apart = [np.abs(one[1:-1] - (one[:-2] + one[2:]) / 2) for one in np.split(residual, ends)]
    size = np.concatenate(apart)
    here = np.concatenate([one[1:-1] for one in np.split(torque, ends)])
    usual = float(np.median(size)) if size.size >= FEWEST else 0.0
    if usual == 0 or not here.any():
        return EVEN
    logs = np.log(np.maximum(size, TINY * usual))
    ratios = np.array([0.0, *AT_PEAK / np.abs(here).max()])
    spread = [float(np.var(logs - np.log1p((ratio * here) ** 2) / 2)) for ratio in ratios]
    best = int(np.argmin(spread))
    if size.size / OVERLAP * math.log(spread[0] / spread[best]) <= math.log(size.size):
        return EVEN
    ratio = float(ratios[best])
    return Uneven(ratio, float(np.mean(1 + (ratio * torque) ** 2)))


def estimate_noise(
    columns: Array, residual: Array, sizes: Sequence[int], uneven: Uneven = EVEN
) -> Noise:
    """Estimates the noise of curves from the residual of a fit.

    Columns and residual [N·m] of uneven noise are divided by its relative deviation, `uneven.at`.
    Columns, the derivatives of the torque by the fitted parameters (samples, p), need not be
    independent; noise is independent between curves.
    """
    basis = independent(columns)
    freedom = residual.size - basis.shape[1]
    likelihood, variance = np.empty(len(GRID)), np.empty(len(GRID))
    for i, (memory, white) in enumerate(GRID):
        whitened, log_det = whiten(np.column_stack([basis, residual]), sizes, memory, white)
        triangle = np.asarray(np.linalg.qr(whitened, mode="r"))
        left = max(float(np.square(triangle)[-1, -1]), np.finfo(float).tiny)
        fitted = np.log(np.abs(np.diag(triangle)[:-1])).sum()
        likelihood[i] = -log_det - fitted - freedom / 2 * math.log(left)
        variance[i] = left / freedom
    weight = np.exp(likelihood - likelihood.max())
    weight[0] *= SIMPLER
    return Noise(weight / weight.sum(), variance, freedom, uneven)


def whiten(values: Array, sizes: Sequence[int], memory: float, white: float) -> tuple[Array, float]:
    """Returns values that are white under this noise, and half its log determinant.

    The slow part is the state of a Kalman filter, whose innovations over their deviations are
    white. The values (samples, m) are series along curves of these sizes, end to end; `memory` is
    the correlation of the slow noise from sample to sample, and `white` the share of white noise in
    the variance, which is 1.
    """
    found = np.array(values, dtype=np.float64)
    ends = np.cumsum([0, *sizes])
    return found, _innovations(found, ends, memory, white)


@njit(cache=True)
def _innovations(values, ends, memory, white) -> float:
    log_det, columns = 0.0, values.shape[1]
    state = np.empty(columns)
    for curve in range(ends.size - 1):
        state[:] = 0.0
        uncertain = 1.0 - white
        for i in range(ends[curve], ends[curve + 1]):
            total = uncertain + white
            gain, deviation = uncertain / total, math.sqrt(total)
            log_det += math.log(deviation)
            for j in range(columns):
                new = values[i, j] - state[j]
                state[j] = memory * (state[j] + gain * new)
                values[i, j] = new / deviation
            uncertain = memory * memory * (1.0 - gain) * uncertain
            uncertain += (1.0 - memory * memory) * (1.0 - white)
    return log_det


def slow_noise(size: int, memory: float, rng: np.random.Generator) -> Array:
    """Returns an AR(1) process of variance 1, shape (size,); `memory` is its correlation."""
    from scipy.signal import lfilter  # slow to import

    pushes = math.sqrt(1 - memory**2) * rng.standard_normal(size)
    first = rng.standard_normal()
    series, _ = lfilter([1.0], [1.0, -memory], pushes, zi=[memory * first])
    return np.asarray(series)


def smoother_noise(curves: Sequence[Curve]) -> float:
    """Returns the deviation [N·m] of the torque from smooth curves through all branches.

    Each branch has its own cubic spline over the samples, whose pieces are shorter after the
    reversal, where a hysteretic torque bends most. The deviation accounts for their number.
    """
    left, freedom = 0.0, 0
    for curve in curves:
        pieces = branches(curve.angle, curve.torque) if curve.angle.size > 2 else ()
        for piece in pieces:
            torque = curve.torque[piece.start : piece.stop]
            columns = _spline(torque.size)
            if torque.size <= columns.shape[1]:
                continue
            rest = torque - columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]
            left += float(rest @ rest)
            freedom += torque.size - columns.shape[1]
    return math.sqrt(left / freedom) if freedom else math.inf


def _spline(samples: int) -> Array:
    """Returns cubic B-splines over a branch, shape (samples, columns)."""
    count = min(max(samples // SAMPLES, 1), PIECES)
    inner = (samples - 1) * np.linspace(0, 1, count + 1) ** 2
    inner = np.maximum(inner, np.arange(count + 1))  # at least one sample in each piece
    ends = np.full(CUBIC, inner[0]), np.full(CUBIC, inner[-1])
    knots = np.concatenate([ends[0], inner, ends[1]])
    return BSpline.design_matrix(np.arange(samples, dtype=float), knots, CUBIC).toarray()
