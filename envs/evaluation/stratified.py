"""Intervals over several tasks at once: what other motions of the same tasks would tell.

Tasks are strata: motions are drawn anew within each, and all policies meet the same ones.
The tests repeat on synthetic scores that nominal 95 % intervals hold the truth in 93 to 97 %.
"""

from collections.abc import Sequence
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from ...checks import at_least, within
from ...errors import InputError
from .statistics import FEWEST_RESAMPLES, LEVELS, Interval, interquartile_mean


def stratified_interval(
    strata: Sequence[ArrayLike], *, level: float = 0.95, resamples: int = 2000, seed: int = 0
) -> Interval:
    """Returns the interquartile mean of all scores and its interval over other motions.

    A percentile bootstrap: each resample draws the motions of every task anew. Deviations are
    widened by sqrt(m / (m - 1)) for m motions, since a resample varies that much less than new
    motions do (Davison and Hinkley 1997, chapter 3.2).

    Args:
        strata: Scores of each task, shape (motions,) each, 2 or more.
        level: How often the interval should hold the truth, 0.5 to 0.99.
        resamples: Number of bootstrap resamples.
        seed: Seed of the resamples; the same seed gives the same interval.

    Raises:
        InputError: A task has fewer than 2 motions, or an option is out of range.
    """
    within("level", level, *LEVELS)
    at_least("resamples", resamples, FEWEST_RESAMPLES)
    at_least("seed", seed, 0)
    scores = [np.asarray(one, np.float64) for one in strata]
    if not scores or min(one.size for one in scores) < 2:
        raise InputError("an interval over tasks needs at least 2 motions of each: give more")
    value = float(interquartile_mean(np.concatenate(scores)))
    rng, drawn = np.random.default_rng(seed), []
    for one in scores:
        drawn.append(one[rng.integers(0, one.size, (resamples, one.size))])
    found = interquartile_mean(np.concatenate(drawn, axis=1))
    if not np.isfinite(found).all():
        return Interval(value, -np.inf, np.inf)
    motions = min(one.size for one in scores)
    away = (found - value) * np.sqrt(motions / (motions - 1))
    low, high = np.quantile(away, [(1 - level) / 2, (1 + level) / 2])
    return Interval(value, value + float(low), value + float(high))


def paired_improvement(
    one: Sequence[ArrayLike], other: Sequence[ArrayLike], *, level: float = 0.95
) -> Interval:
    """Returns the probability that one policy is better than another on the same motion.

    A tie counts a half. The interval is Wilson's (1927) for as many motions as there are; it keeps
    a width where every motion agrees, which a bootstrap does not.

    Args:
        one: Scores of each task, larger is better, shape (motions,) each.
        other: Scores of the other policy on the same motions.
        level: How often the interval should hold the truth, 0.5 to 0.99.

    Raises:
        InputError: The motions are not the same number, or the level is out of range.
    """
    within("level", level, *LEVELS)
    first, second = (np.concatenate([np.asarray(x) for x in xs]) for xs in (one, other))
    if first.shape != second.shape:
        raise InputError(
            f"one has {first.size} motions and other {second.size}: give scores of the same ones"
        )
    better = float(np.mean((first > second) + 0.5 * (first == second)))
    z, n = NormalDist().inv_cdf(0.5 + level / 2), first.size
    middle = (better + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(better * (1 - better) / n + z**2 / (4 * n**2))
    return Interval(better, max(0.0, float(middle - half)), min(1.0, float(middle + half)))
