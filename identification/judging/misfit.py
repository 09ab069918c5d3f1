"""F tests of whether a residual is noise, and hence whether a model describes the curves.

A residual that is noise has no smooth part: none over the angle, the direction of motion and the
depth of a branch that is the same in all curves. And it has no part along the torque that a known
fault of a rig would add. Both are columns beside the derivatives of the fit, and an F test gives
the probability that noise alone explains as much (Seber and Wild 1989, Nonlinear Regression,
section 5.3). The noise is estimated with the columns in place, so that a misfit does not count as
noise; or from repeated curves, where there are any.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from scipy.special import fdtrc

from ...arrays import Array
from ...hysteresis.loops import branches, reversals
from ..data.curves import Curve, Curves
from ..fits.tangent import beside, independent
from .noise import EVEN, GRID, Noise, Uneven, estimate_noise, whiten
from .sentences import Remark

BY_ANGLE, BY_DEPTH = 5, 3  # degrees of the smooth columns
LEAST_FREEDOM = 5  # least excess of samples over columns; few samples allow fewer columns
NEARLY_NONE = 1e-6  # weight of a noise that is left out
SAME_PATH = 0.02  # largest distance of two curves along one path, as a share of the range
FAR = 6.0  # deviations from the neighbors, which normal noise reaches once in 500 million samples
SOME = 3.0  # deviations that 0.3 % of the samples of normal noise reach
HEAVY = 0.015  # share of samples between both, from which on the noise itself has heavy tails
FEWEST = 2  # a single outlier may be a reversal
RUNS = (3, 4, 6, 8, 12)  # lengths of runs
FAR_RUN = 9.0  # deviations of a run from the samples before and after it
NEAR_TURN = 6  # samples at a turn, where a misfit looks like a run


@dataclass(frozen=True, kw_only=True)
class Explained:
    """How much of a residual some columns explain."""

    statistic: float  # F, averaged over the noises
    probability: float  # of noise alone to explain as much
    columns: int  # number of the columns beside those of the fit
    noise: Noise  # with the columns in place, or that of repeated curves


def explained(
    residual: Array,
    slopes: Array,
    columns: Array,
    sizes: Sequence[int],
    known: Noise | None = None,
    uneven: Uneven = EVEN,
) -> Explained:
    """Tests columns (samples, q) beside the derivatives of a fit (samples, p).

    All of them are divided by the relative deviation of uneven noise, as is the residual [N·m]. The
    noise is estimated if repeated curves do not show it.
    """
    inner = independent(slopes)
    outer = independent(beside(inner, columns))
    outer = outer[:, : max(residual.size - inner.shape[1] - LEAST_FREEDOM, 0)]
    both = np.column_stack([inner, outer])
    noise = known or estimate_noise(both, residual, sizes, uneven)
    freedom = noise.freedom
    statistic = probability = 0.0
    for weight, variance, (memory, white) in zip(noise.weight, noise.variance, GRID, strict=True):
        if weight < NEARLY_NONE or not outer.size:
            continue
        whitened, _ = whiten(np.column_stack([both, residual]), sizes, memory, white)
        triangle = np.asarray(np.linalg.qr(whitened, mode="r"))
        # The last column has the part of the residual that each column explains.
        gained = float(np.sum(triangle[inner.shape[1] : both.shape[1], -1] ** 2))
        value = gained / outer.shape[1] / max(float(variance), np.finfo(float).tiny)
        statistic += weight * value
        probability += weight * float(fdtrc(outer.shape[1], freedom, value))
    return Explained(
        statistic=statistic,
        probability=probability if outer.size else 1.0,
        columns=outer.shape[1],
        noise=noise,
    )


def smooth_columns(curves: Sequence[Curve]) -> Array:
    """Returns smooth functions of angle, direction and depth, shape (samples, q).

    The depth of a sample is its distance from the last reversal, over the range of all angles.
    """
    low, high = Curves(curves).angle_range
    parts = []
    for curve in curves:
        direction, turn = np.ones(curve.angle.size), np.full(curve.angle.size, curve.angle[0])
        for piece in branches(curve.angle, curve.torque) if curve.angle.size > 2 else ():
            direction[piece.start + 1 : piece.stop] = piece.direction
            turn[piece.start + 1 : piece.stop] = piece.angle[0]
        place = 2 * (curve.angle - low) / (high - low) - 1
        depth = 2 * np.abs(curve.angle - turn) / (high - low) - 1
        by_angle = chebyshev.chebvander(place, BY_ANGLE)
        by_depth = chebyshev.chebvander(depth, BY_DEPTH)[:, 1:]
        across = (place * depth)[:, None]
        even = np.column_stack([by_angle, by_depth, across])
        parts.append(np.column_stack([even, even * direction[:, None]]))
    return np.concatenate(parts)


def repeated_noise(curves: Sequence[Curve], uneven: Uneven = EVEN) -> Noise | None:
    """Returns the noise from differences of curves along one path; None without such curves.

    Half the difference of two curves is free of everything that both have, a misfit too. A
    constant, a slope and a share of the torque count as faults of one of them, and not as noise.
    """
    low, high = Curves(curves).angle_range
    differences, sizes, shares, columns = [], [], [], []
    left = list(curves)
    while left:
        first = left.pop(0)
        for other in left:
            if other.torque.size != first.torque.size or np.all(other.torque == first.torque):
                continue  # a copy is no repeat
            if np.abs(other.angle - first.angle).max() <= SAME_PATH * (high - low):
                differences.append((first.torque - other.torque) / math.sqrt(2))
                sizes.append(first.torque.size)
                shares.append(first.torque)
                left.remove(other)
                break
    if not differences:
        return None
    for i, (size, share) in enumerate(zip(sizes, shares, strict=True)):
        block = np.zeros((sum(sizes), 3))
        begin = sum(sizes[:i])
        line = np.vander(np.linspace(-1, 1, size), 2)
        block[begin : begin + size] = np.column_stack([line, share])
        columns.append(block)
    scale = uneven.at(np.concatenate(shares))
    lines = np.column_stack(columns) / scale[:, None]
    return estimate_noise(lines, np.concatenate(differences) / scale, sizes, uneven)


def outliers(
    residual: Array, curves: Sequence[Curve], scale: Array, *, is_misfit: bool
) -> list[Remark]:
    """Returns remarks on samples that are errors of the sensor.

    The first statistic is the residual less the mean of its two neighbors, which is small for a
    smooth misfit; the second is the mean of a run less that of the samples before and after. Both
    are divided by a deviation from the median, which outliers hardly change. Noise whose tails
    are heavy has no outliers. The residual is over `scale`, the relative deviation of the noise. A
    model that surely is wrong may be the cause itself: then there is no remark.
    """
    ends = np.cumsum([curve.torque.size for curve in curves])[:-1]
    parts = np.split(residual, ends)
    apart = np.concatenate([one[1:-1] - (one[:-2] + one[2:]) / 2 for one in parts])
    usual = _deviation(apart)
    if usual == 0 or is_misfit:
        return []  # no noise, or torques so coarse that most samples repeat the one before
    size = np.pad(np.abs(apart) / usual, 1)
    far_off = size > FAR
    near = np.pad(far_off[:-2] | far_off[2:], 1)  # an outlier spoils the means of its neighbors
    if np.mean((size > SOME) & ~far_off & ~near) > HEAVY:
        return []
    peaks = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])  # outliers, not their neighbors
    inner = np.concatenate([one[1:-1] for one in np.split(scale, ends)])
    far = (usual * inner * size[1:-1])[peaks & (size[1:-1] > FAR)]
    if far.size >= FEWEST:
        values = {"count": far.size, "torque": float(far.max()), "far": FAR}
        return [Remark("outliers", values)]
    return _runs(parts, np.split(scale, ends), curves)


def _runs(parts: Sequence[Array], scales: Sequence[Array], curves: Sequence[Curve]) -> list[Remark]:
    """Returns a remark on the run that is farthest from the samples around it, if it is far."""
    best = (FAR_RUN, 0.0, 0, 0, "")
    for length in RUNS:
        found = [_apart(part, length) for part in parts]
        usual = _deviation(np.concatenate(found))
        if usual == 0:
            continue
        for series, scale, curve in zip(found, scales, curves, strict=True):
            first = np.arange(series.size) + length  # index of the first sample of each run
            turns = np.array([0, *reversals(curve.angle).tolist(), curve.angle.size - 1])[:, None]
            near = (first <= turns + NEAR_TURN) & (first + length >= turns - NEAR_TURN)
            free = np.where(near.any(axis=0), 0.0, series)
            if free.size and (size := np.abs(free).max() / usual) > best[0]:
                at = int(np.argmax(np.abs(free)))
                height = float(free[at] * scale[at + length])
                best = (size, height, at + length, length, curve.name)
    times, height, begin, length, name = best
    values = {"times": times, "torque": height, "begin": begin, "count": length, "curve": name}
    return [Remark("outliers run", values)] if name else []


def _apart(values: Array, length: int) -> Array:
    """Returns the mean of each run less the mean of as many samples on each side."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    if total.size <= 3 * length:
        return np.empty(0)
    means = (total[length:] - total[:-length]) / length
    before, run, after = means[: -2 * length], means[length:-length], means[2 * length :]
    return run - (before + after) / 2


def _deviation(values: Array) -> float:
    return 1.4826 * float(np.median(np.abs(values))) if values.size else 0.0
