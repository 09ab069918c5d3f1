"""Scores of extras in an evaluation: mean costs, and the relief of each cost."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...tables import Rows
from ..extras import SCORES, STANDARD, Scored
from .relief import relief_interval
from .scores import REFERENCES
from .statistics import Interval, interval_text

Facts = Mapping[str, Any]


class Cost(NamedTuple):
    """A cost of motions under one policy."""

    mean: float  # over motions and settings; infinite for failed policies and missing costs
    relief: Interval | None  # interval over motions; None where no suit costs enough
    between: tuple[float, float] | None  # least and greatest relief over all conventions, if known


Costs = Mapping[str, Mapping[str, Cost | None]]
"""Costs by policy and by the name of the cost; None where no motion has the cost."""


def cost_of(scored: Mapping[str, Scored], policy: str, cost: str, least: float) -> Cost:
    """Returns a cost of the motions of an evaluation; without references there is no relief.

    Args:
        scored: Scores of all policies.
        policy: Name of a policy.
        cost: Name of the cost.
        least: Least cost of a suit for which relief has a meaning.
    """
    own, found = scored[policy].costs[cost], []
    for convention in own if all(name in scored for name in REFERENCES) else ():
        series = [scored[name].costs[cost][convention] for name in (*REFERENCES, policy)]
        finite = np.isfinite(series).all()
        found.append((convention, relief_interval(*series, least=least) if finite else None))
    values = [one.value for _, one in found if one is not None]
    between = (min(values), max(values)) if values and len(values) == len(found) else None
    return Cost(float(np.mean(own[STANDARD])), dict(found).get(STANDARD), between)


def costs_of(name: str, scored: Mapping[str, Scored]) -> dict[str, dict[str, Cost]]:
    """Returns all costs of a score, by policy."""
    least = SCORES.find(name).least
    return {
        policy: {cost: cost_of(scored, policy, cost, one) for cost, one in least.items()}
        for policy in scored
    }


def plain(name: str, scored: Scored, costs: Mapping[str, Cost | None]) -> dict[str, Any]:
    """Returns a score of one policy as plain values with units."""
    found = {**scored.costs, **scored.facts, "units": SCORES.find(name).units}
    for cost, one in costs.items():
        found[f"{cost}_relief"] = one and one.relief and one.relief.to_dict()
        found[f"{cost}_relief_range"] = one and one.between
    return found


def drawn_policies(name: str, scored: Mapping[str, Scored]) -> list[str]:
    """Returns the names that a figure shows: the suit alone, and the policy with the least cost."""
    cost = next(iter(SCORES.find(name).least))
    means = {policy: np.mean(one.costs[cost][STANDARD]) for policy, one in scored.items()}
    free = [policy for policy in means if policy not in REFERENCES]
    best = min(free, key=lambda one: np.nan_to_num(means[one], nan=np.inf))
    return [one for one in (REFERENCES[1], best) if one in scored]


def cost_remarks(name: str, scored: Mapping[str, Scored], costs: Costs) -> Iterator[str]:
    """Yields sentences about limits of the numbers of an evaluation, and the cost of the suit."""
    score = SCORES.find(name)
    yield from limit_remarks(name, {policy: one.facts for policy, one in scored.items()})
    if all(policy in costs for policy in REFERENCES):
        for cost in score.least:
            means = [one.mean for policy in REFERENCES if (one := costs[policy][cost])]
            unit = "" if score.units[cost] == "1" else f" {score.units[cost]}"
            change = " to ".join(f"{mean:.3g}" for mean in means)
            yield f"{name}: the suit changes {cost} from {change}{unit}."


def limit_remarks(name: str, facts: Mapping[str, Facts]) -> Iterator[str]:
    """Yields a sentence for each limit that facts exceed: the worst case and the number of cases.

    A case is a policy, or a policy in a setting.
    """
    for limit, (least, sentence) in SCORES.find(name).limits.items():
        known = {place: one.get(limit) for place, one in facts.items()}
        found = {p: one for p, one in known.items() if isinstance(one, float) and one > least}
        if found:
            worst = max(found, key=lambda place: found[place])
            most = sentence.format(found[worst])
            yield f"{worst}: {most}; scores are limited so in {len(found)} of {len(facts)} cases."


def cost_table(name: str, costs: Costs, facts: Mapping[str, Sequence[Facts]]) -> Rows:
    """Returns a row per policy: each cost, its relief, the range of relief, and facts by name.

    A policy has one set of facts for each setting.
    """
    score = SCORES.find(name)
    every = [pair for some in facts.values() for one in some for pair in one.items()]
    lists = {fact: len(one) for fact, one in every if isinstance(one, dict)}
    header = ["policy"]
    for cost in score.least:
        header += [f"{cost}\n[{score.units[cost]}]", "its relief", "range of\nthat"]
    header += [f"{fact}\n[{score.units.get(fact, '1')}]" for fact in lists]
    rows = []
    for policy, of in costs.items():
        cells = [cell for one in of.values() for cell in _cells(one)]
        rows.append([policy, *cells, *(_greatest(facts[policy], *one) for one in lists.items())])
    return header, rows


def _cells(cost: Cost | None) -> list[str]:
    if cost is None:
        return ["-"] * 3
    between = "-" if cost.between is None else "{:.2f}\nto {:.2f}".format(*cost.between)
    return [f"{cost.mean:.3g}", interval_text(cost.relief), between]


def _greatest(facts: Sequence[Facts], name: str, count: int) -> str:
    """Returns the `count` greatest numbers of a fact by name, over all settings."""
    named = (one[name] for one in facts if isinstance(one.get(name), dict))
    pairs = (pair for one in named for pair in one.items())
    most = dict(sorted(pairs, key=lambda pair: pair[1]))
    order = sorted(most, key=lambda label: -most[label])[:count]
    return "\n".join(f"{label} {most[label]:.2g}" for label in order) or "-"
