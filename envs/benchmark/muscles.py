"""What results say about muscles: power, activation, and relief of both over settings."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ...arrays import Array
from ..evaluation.scores import Values
from ..evaluation.statistics import Interval, interquartile_mean
from ..muscles import STANDARD, MuscleScore
from ..muscles.scores import LEAST_COST, LOADED
from .results import Result
from .standings import Measure, Standings, aligned, over_motions
from .suite import Setting


@dataclass(frozen=True)
class MuscleStanding:
    """What several settings cost the wearer's muscles under one policy.

    Attributes:
        power: Metabolic power [W], mean over motions and settings; infinite where the policy could
            not act, or a motion ended too soon.
        effort: Root mean square activation, likewise.
        power_relief: Interquartile mean of relief over motions and settings, and what other motions
            would tell; None where no suit costs enough for relief to have a meaning.
        power_relief_range: Least and greatest relief over all conventions; None where one of these
            settings has none under a convention.
        effort_relief: Relief of activation, as `power_relief`.
        loaded: The three most loaded muscles, with the greatest activation of a setting.
    """

    power: float
    effort: float
    power_relief: Interval | None
    power_relief_range: tuple[float, float] | None
    effort_relief: Interval | None
    loaded: Mapping[str, float]


def muscle_measure(what: str, convention: str = STANDARD) -> Measure:
    """Returns the measure whose relief is that of muscles.

    Args:
        what: "power" or "effort".
        convention: Name of a convention.
    """
    return Measure(partial(_series, what, convention), LEAST_COST[what])


def muscle_standing(
    standings: Standings, policy: str, settings: Iterable[Setting]
) -> MuscleStanding | None:
    """Returns what settings cost the muscles under a policy; None if no trial has muscles."""
    settings = list(settings)
    mine = [one for s in settings if (one := standings.of(s, policy)) is not None]
    scores = [one.muscles for one in mine if one.muscles is not None]
    if not scores:
        return None

    def mean(what: str) -> float:
        found = [values for one in mine if (values := _series(what, STANDARD, one)) is not None]
        return float(np.mean(np.concatenate(found)))

    def reliefs(what: str, convention: str = STANDARD) -> dict[Setting, Array]:
        measure = muscle_measure(what, convention)
        found = {s: standings.relief(s, policy, of=measure) for s in settings}
        return {s: relief for s, relief in found.items() if relief is not None}

    return MuscleStanding(
        power=mean("power"),
        effort=mean("effort"),
        power_relief=over_motions([*reliefs("power").values()]),
        power_relief_range=_range([reliefs("power", name) for name in scores[0].power]),
        effort_relief=over_motions([*reliefs("effort").values()]),
        loaded=_most_loaded(scores),
    )


def _series(what: str, convention: str, result: Result) -> Values | None:
    """Returns power or activation of each motion; None where muscles are not known."""
    if result.failed is not None:
        return (math.inf,) * len(result.effort)
    return None if result.muscles is None else getattr(result.muscles, what).get(convention)


def _range(by_convention: Sequence[Mapping[Setting, Array]]) -> tuple[float, float] | None:
    first = by_convention[0].keys()
    if not first or any(one.keys() != first for one in by_convention):
        return None
    means = [interquartile_mean(aligned([*one.values()]).ravel()) for one in by_convention]
    return float(min(means)), float(max(means))


def _most_loaded(scores: Iterable[MuscleScore]) -> dict[str, float]:
    most: dict[str, float] = {}
    for score in scores:
        for name, load in score.loaded.items():
            most[name] = max(load, most.get(name, 0.0))
    return dict(sorted(most.items(), key=lambda pair: -pair[1])[:LOADED])
