"""What a score of an extra says of a policy: mean costs, and the relief of each.

Relief of an evaluation is a mean over motions, that of the benchmark the interquartile mean over
motions and settings.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ..evaluation import REFERENCES
from ..evaluation.relief import relief_interval
from ..evaluation.statistics import Interval, interquartile_mean
from ..extras import STANDARD, Scored
from .results import Result
from .standings import Measure, Standings, aligned, over_motions
from .suite import Setting


class Cost(NamedTuple):
    """A cost of motions under one policy.

    Attributes:
        mean: Mean over motions and settings; infinite where the policy could not act, or a motion
            has no cost.
        relief: Relief, and what other motions would tell; None where no suit costs enough.
        between: Least and greatest relief over all conventions; None where a setting has none under
            one of them.
    """

    mean: float
    relief: Interval | None
    between: tuple[float, float] | None


def cost_of(scored: Mapping[str, Scored], policy: str, cost: str, least: float) -> Cost:
    """Returns what the motions of an evaluation cost; without references there is no relief.

    Args:
        scored: Scores of all policies.
        policy: Name of one of them.
        cost: Name of the cost.
        least: Cost of a suit for relief to have a meaning.
    """
    own, found = scored[policy].costs[cost], []
    for convention in own if all(name in scored for name in REFERENCES) else ():
        series = [scored[name].costs[cost][convention] for name in (*REFERENCES, policy)]
        finite = np.isfinite(series).all()
        found.append((convention, relief_interval(*series, least=least) if finite else None))
    values = [one.value for _, one in found if one is not None]
    between = (min(values), max(values)) if values and len(values) == len(found) else None
    return Cost(float(np.mean(own[STANDARD])), dict(found).get(STANDARD), between)


def cost_over(
    standings: Standings, policy: str, settings: Iterable[Setting], measures: Mapping[str, Measure]
) -> Cost | None:
    """Returns what settings cost under a policy; None where no trial has the cost.

    Args:
        standings: Results of the benchmark.
        policy: Name of the policy.
        settings: The settings.
        measures: The cost under each convention.
    """
    settings = list(settings)
    mine = [one for s in settings if (one := standings.of(s, policy)) is not None]
    costs = [one for result in mine if (one := measures[STANDARD].series(result)) is not None]
    if not costs or all(one.failed for one in mine):
        return None
    reliefs: dict[str, dict[Setting, Array]] = {}
    for convention, measure in measures.items():
        found = {s: standings.relief(s, policy, of=measure) for s in settings}
        reliefs[convention] = {s: one for s, one in found.items() if one is not None}
    standard = reliefs[STANDARD]
    between = None
    if standard and all(one.keys() == standard.keys() for one in reliefs.values()):
        means = [_interquartile([*one.values()]) for one in reliefs.values()]
        between = float(min(means)), float(max(means))
    mean = float(np.mean(np.concatenate(costs)))
    return Cost(mean, over_motions([*standard.values()]), between)


def measures_of(
    results: Sequence[Result], score: str, cost: str, least: float
) -> dict[str, Measure]:
    """Returns a cost of a score as measures, by each convention that results have."""
    costs = [one.extra.get(score, {}).get("costs", {}).get(cost, {}) for one in results]
    conventions = dict.fromkeys((STANDARD, *(name for one in costs for name in one)))
    return {name: Measure(partial(_series, score, cost, name), least) for name in conventions}


def _series(score: str, cost: str, convention: str, result: Result) -> Sequence[float] | None:
    """Returns the cost of each motion; None where the result does not have it."""
    if result.failed is not None:
        return (math.inf,) * len(result.effort)
    kept = result.extra.get(score, {}).get("costs", {}).get(cost, {}).get(convention)
    return None if kept is None else [math.inf if one is None else one for one in kept]


def _interquartile(values: Sequence[Array]) -> float:
    return float(interquartile_mean(aligned(values).ravel()))
