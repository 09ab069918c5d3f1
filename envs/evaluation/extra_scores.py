"""Scores of extras in an evaluation: mean costs, and the relief of each cost."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...tables import Rows
from ..extras import SCORES, STANDARD, Scored
from .relief import relief_interval
from .scores import REFERENCES
from .statistics import Interval, interval_text


class Cost(NamedTuple):
    """A cost of motions under one policy."""

    mean: float  # over motions
    relief: Interval | None  # interval over motions; None where no suit costs enough
    between: tuple[float, float] | None  # least and greatest relief over all conventions, if known


Costs = Mapping[str, Mapping[str, Cost]]
"""Costs by policy and by the name of the cost."""


def cost_of(
    scored: Mapping[str, Scored],
    policy: str,
    cost: str,
    least: float,
    motion: Sequence[int] = (),
) -> Cost:
    """Returns a cost of the motions of an evaluation; without references there is no relief.

    Args:
        scored: Scores of all policies.
        policy: Name of a policy.
        cost: Name of the cost.
        least: Least cost of a suit for which relief has a meaning.
        motion: Numbers of motions, of which equal ones are the same motion.
    """
    own, found = scored[policy].costs[cost], []
    for convention in own if all(name in scored for name in REFERENCES) else ():
        series = [scored[name].costs[cost][convention] for name in (*REFERENCES, policy)]
        finite = np.isfinite(series).all()
        one = relief_interval(*series, least=least, motion=motion) if finite else None
        found.append((convention, one))
    values = [one.value for _, one in found if one is not None]
    between = (min(values), max(values)) if values and len(values) == len(found) else None
    return Cost(float(np.mean(own[STANDARD])), dict(found).get(STANDARD), between)


def costs_of(
    name: str, scored: Mapping[str, Scored], motion: Sequence[int] = ()
) -> dict[str, dict[str, Cost]]:
    """Returns all costs of a score, by policy; `motion` as in `cost_of`."""
    least = SCORES.find(name).least
    return {
        policy: {cost: cost_of(scored, policy, cost, one, motion) for cost, one in least.items()}
        for policy in scored
    }


def plain(name: str, scored: Scored, costs: Mapping[str, Cost]) -> dict[str, Any]:
    """Returns a score of one policy as plain values with units."""
    found = {**scored.costs, **scored.facts, "units": SCORES.find(name).units}
    for cost, one in costs.items():
        found[f"{cost}_relief"] = one.relief and one.relief.to_dict()
        found[f"{cost}_relief_range"] = one.between
    return found


def drawn_policies(name: str, scored: Mapping[str, Scored]) -> list[str]:
    """Returns the names that a figure shows: the suit alone, and the policy with the least cost."""
    cost = next(iter(SCORES.find(name).least))
    means = {policy: np.mean(one.costs[cost][STANDARD]) for policy, one in scored.items()}
    free = [policy for policy in means if policy not in REFERENCES]
    best = min(free, key=lambda one: np.nan_to_num(means[one], nan=np.inf))
    return [one for one in (REFERENCES[1], best) if one in scored]


def cost_remarks(name: str, scored: Mapping[str, Scored], costs: Costs) -> Iterator[str]:
    """Yields sentences about limits of the numbers of an evaluation, and the cost of the suit.

    The sentence about a limit names the policy that exceeds the limit most.
    """
    score = SCORES.find(name)
    for limit, (least, sentence) in score.limits.items():
        known = {policy: one.facts.get(limit) for policy, one in scored.items()}
        found = {p: one for p, one in known.items() if isinstance(one, float) and one > least}
        if found:
            worst = max(found, key=lambda policy: found[policy])
            most = sentence.format(found[worst])
            yield f"{worst}: {most}; scores are limited so in {len(found)} of {len(scored)} cases."
    if all(policy in costs for policy in REFERENCES):
        for cost in score.least:
            unit = "" if score.units[cost] == "1" else f" {score.units[cost]}"
            change = " to ".join(f"{costs[policy][cost].mean:.3g}" for policy in REFERENCES)
            yield f"{name}: the suit changes {cost} from {change}{unit}."


def cost_table(name: str, scored: Mapping[str, Scored], costs: Costs) -> Rows:
    """Returns a row per policy: each cost, its relief, the range of relief, and facts by name."""
    score = SCORES.find(name)
    facts = (pair for one in scored.values() for pair in one.facts.items())
    named = list(dict.fromkeys(fact for fact, one in facts if isinstance(one, dict)))
    header = ["policy"]
    for cost in score.least:
        header += [f"{cost}\n[{score.units[cost]}]", "its relief", "range of\nthat"]
    header += [f"{fact}\n[{score.units.get(fact, '1')}]" for fact in named]
    rows = []
    for policy, of in costs.items():
        cells = []
        for cost in of.values():
            between = "-" if cost.between is None else "{:.2f}\nto {:.2f}".format(*cost.between)
            cells += [f"{cost.mean:.3g}", interval_text(cost.relief), between]
        rows.append([policy, *cells, *(_numbers(scored[policy].facts.get(one)) for one in named)])
    return header, rows


def _numbers(fact: float | dict[str, float] | None) -> str:
    """Returns the numbers of a fact by name, the greatest first."""
    numbers = sorted(fact.items(), key=lambda pair: -pair[1]) if isinstance(fact, dict) else ()
    return "\n".join(f"{label} {number:.2g}" for label, number in numbers) or "-"
