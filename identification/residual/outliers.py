"""Samples, or short runs of samples, that are far from their neighbors."""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...hysteresis.loops import reversals
from ..curves import Curve
from ..remarks import Remark

FAR = 6.0  # deviations from the neighbors, which normal noise reaches once in 500 million samples
SOME = 3.0  # deviations that 0.3 % of the samples of normal noise reach
HEAVY = 0.015  # share of samples between both, from which on the noise itself has heavy tails
FEWEST = 2  # a single outlier may be a reversal
RUNS = (3, 4, 6, 8, 12)  # lengths of runs
FAR_RUN = 9.0  # deviations of a run from the samples before and after it
NEAR_TURN = 6  # samples at a turn, where a misfit looks like a run


def outliers(
    residual: Array, curves: Sequence[Curve], scale: Array, *, is_misfit: bool
) -> list[Remark]:
    """Returns remarks on samples that a sensor cannot have measured.

    The first statistic is the residual less the mean of its two neighbors, which a smooth misfit
    leaves small; the second one the mean of a run less that of the samples before and after. Both
    are divided by their deviation by the median, which outliers leave as it is. Noise whose tails
    are heavy has no outliers.

    Args:
        residual: Residual of the fit [N·m] over the scale, shape (samples,).
        curves: The fitted curves.
        scale: Relative deviation of the noise of each sample, shape (samples,).
        is_misfit: Whether the model surely is wrong; then it may be at fault, and none is returned.
    """
    ends = np.cumsum([curve.torque.size for curve in curves])[:-1]
    parts = np.split(residual, ends)
    apart = np.concatenate([one[1:-1] - (one[:-2] + one[2:]) / 2 for one in parts])
    usual = _deviation(apart)
    if usual == 0 or is_misfit:
        return []  # no noise, or torques so coarse that most samples repeat the one before
    size = np.pad(np.abs(apart) / usual, 1)
    far_off = size > FAR
    beside = np.pad(far_off[:-2] | far_off[2:], 1)  # an outlier spoils the means of its neighbors
    if np.mean((size > SOME) & ~far_off & ~beside) > HEAVY:
        return []
    peaks = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])  # outliers, not their neighbors
    inner = np.concatenate([one[1:-1] for one in np.split(scale, ends)])
    far = (usual * inner * size[1:-1])[peaks & (size[1:-1] > FAR)]
    if far.size >= FEWEST:
        return [
            Remark(
                "outliers",
                f"{far.size} samples are up to {far.max():.2g} N·m off their neighbors, more than "
                f"{FAR:g} times the usual deviation: remove these outliers, or search with an "
                "objective that bears them, such as by sa-pso",
                ("objective", "robust"),
            )
        ]
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
    _, height, begin, length, name = best
    if not name:
        return []
    return [
        Remark(
            "outliers",
            f"{length} samples of curve {name!r} from sample {begin} on are {height:+.2g} N·m off "
            f"those before and after, {best[0]:.0f} times the usual deviation: remove this run",
        )
    ]


def _apart(values: Array, length: int) -> Array:
    """Returns the mean of each run less that of as many samples on each side."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    if total.size <= 3 * length:
        return np.empty(0)
    means = (total[length:] - total[:-length]) / length
    before, run, after = means[: -2 * length], means[length:-length], means[2 * length :]
    return run - (before + after) / 2


def _deviation(values: Array) -> float:
    return 1.4826 * float(np.median(np.abs(values))) if values.size else 0.0
