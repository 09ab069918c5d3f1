"""Scores of extras: tables, remarks and plain values of an evaluation and of the benchmark."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...errors import shown
from ...tables import Rows
from ..evaluation import REFERENCES
from ..evaluation.report import interval_text
from ..extras import SCORES, STANDARD, Score, Scored
from .costs import Cost, cost_of, cost_over, measures_of
from .results import Result
from .standings import Measure, Standings
from .suite import Setting

Facts = Mapping[str, Any]


class Said(NamedTuple):
    """What results say about one score: text in Markdown, tables by title, and remarks."""

    text: str
    tables: dict[str, Rows]
    remarks: list[str]


def evaluation_says(name: str, scored: Mapping[str, Scored]) -> tuple[Said, dict[str, Any]]:
    """Returns what a score says about the policies of an evaluation, and plain values of each."""
    score, found, values = SCORES.find(name), {}, {}
    for policy, one in scored.items():
        costs = {cost: cost_of(scored, policy, cost, least) for cost, least in score.least.items()}
        found[policy] = costs, [one.facts]
        values[policy] = {**one.costs, **one.facts, "units": score.units}
        for cost, its in costs.items():
            values[policy][f"{cost}_relief"] = its.relief and its.relief.to_dict()
            values[policy][f"{cost}_relief_range"] = its.between
    remarks = [*_limits(score, {policy: one.facts for policy, one in scored.items()})]
    if all(policy in found for policy in REFERENCES):
        for cost in score.least:
            unsuited, suited = (f"{found[one][0][cost].mean:.3g}" for one in REFERENCES)
            unit = "" if score.units[cost] == "1" else f" {score.units[cost]}"
            remarks.append(f"{name}: the suit changes {cost} from {unsuited} to {suited}{unit}.")
    return Said(score.text, {name: _table(score, found)}, remarks), values


def drawn_policies(name: str, scored: Mapping[str, Scored]) -> list[str]:
    """Returns the suit alone and the policy that costs least, which a figure shows."""
    cost = next(iter(SCORES.find(name).least))
    means = {policy: np.mean(one.costs[cost][STANDARD]) for policy, one in scored.items()}
    free = [policy for policy in means if policy not in REFERENCES]
    best = min(free, key=lambda one: np.nan_to_num(means[one], nan=np.inf))
    return [one for one in (REFERENCES[1], best) if one in scored]


def benchmark_says(results: Sequence[Result]) -> dict[str, Said]:
    """Returns what results of the benchmark say about each score that they have."""
    found = {}
    for name in dict.fromkeys(name for one in results for name in one.extra):
        if name not in SCORES:
            found[name] = Said("", {}, [f"note: no extra with the score {shown(name)} is here"])
            continue
        score, remarks = SCORES.find(name), [*_gaps(name, results)]
        facts = {
            f"{one.policy} in {one.task} at {one.level} with {one.believed}": _facts(one, name)
            for one in results
            if _facts(one, name)
        }
        tables = _tables(name, score, results)
        found[name] = Said(score.text, tables, [*remarks, *_limits(score, facts)])
    return found


def _tables(name: str, score: Score, results: Sequence[Result]) -> dict[str, Rows]:
    standings, tables = Standings(results), {}
    costs = {cost: measures_of(results, name, cost, one) for cost, one in score.least.items()}
    for level in standings.levels:
        settings, found = standings.settings_at(level), {}
        for policy in standings.policies_at(level):
            its = {c: cost_over(standings, policy, settings, of) for c, of in costs.items()}
            mine = [one for s in settings if (one := standings.of(s, policy)) is not None]
            found[policy] = its, [_facts(one, name) for one in mine]
        tables[f"{level}: {name}"] = _table(score, found)
        first, of = next(iter(costs.items()))
        rows = [
            [s.task, s.believed, *(_cell(standings, s, policy, of[STANDARD]) for policy in found)]
            for s in settings
        ]
        tables[f"{level}: {name}, {first} by task"] = ["task", "believed", *found], rows
    return tables


def _facts(result: Result, name: str) -> Facts:
    return result.extra.get(name, {}).get("facts", {})


def _table(
    score: Score, found: Mapping[str, tuple[Mapping[str, Cost | None], Sequence[Facts]]]
) -> Rows:
    """Returns a row per policy: each cost, its relief, the range of that, and facts by name."""
    every = [pair for _, facts in found.values() for one in facts for pair in one.items()]
    lists = {name: len(one) for name, one in every if isinstance(one, dict)}
    header = ["policy"]
    for cost in score.least:
        header += [f"{cost}\n[{score.units[cost]}]", "its relief", "range of\nthat"]
    header += [f"{name}\n[{score.units.get(name, '1')}]" for name in lists]
    rows = []
    for policy, (costs, facts) in found.items():
        cells = [cell for one in costs.values() for cell in _cells(one)]
        rows.append([policy, *cells, *(_greatest(facts, *one) for one in lists.items())])
    return header, rows


def _cells(cost: Cost | None) -> list[str]:
    if cost is None:
        return ["-"] * 3
    between = "-" if cost.between is None else f"{cost.between[0]:.2f}\nto {cost.between[1]:.2f}"
    return [f"{cost.mean:.3g}", interval_text(cost.relief), between]


def _greatest(facts: Sequence[Facts], name: str, count: int) -> str:
    """Returns the greatest numbers of a fact by name, each the greatest of all settings."""
    named = [one[name] for one in facts if isinstance(one.get(name), dict)]
    pairs = [pair for one in named for pair in one.items()]
    most = dict(sorted(pairs, key=lambda pair: pair[1]))
    order = sorted(most, key=lambda label: -most[label])[:count]
    return "\n".join(f"{label} {most[label]:.2g}" for label in order) or "-"


def _cell(standings: Standings, setting: Setting, policy: str, measure: Measure) -> str:
    found = standings.of(setting, policy)
    if found is not None and found.failed:
        return "failed"
    series = found and measure.series(found)
    if not series:
        return "-"
    relief = standings.relief(setting, policy, of=measure)
    return f"{np.mean(series):.3g}" + ("" if relief is None else f"\n{np.mean(relief):.2f}")


def _gaps(name: str, results: Sequence[Result]) -> Iterator[str]:
    """Yields sentences: which trials have no score, and why."""
    without = sum(name not in one.extra and not one.failed for one in results)
    if without:
        yield f"note: {without} of {len(results)} trials were run without --score {name}"
    kept = [(one.task, one.extra.get(name, {})) for one in results]
    for task, reason in {task: one["reason"] for task, one in kept if "reason" in one}.items():
        yield f"note: {name} cannot be scored in {task}: {reason}"


def _limits(score: Score, facts: Mapping[str, Facts]) -> Iterator[str]:
    """Yields sentences: what limits the numbers, where most, and in how many scores."""
    for limit, (least, sentence) in score.limits.items():
        known = {place: one.get(limit) for place, one in facts.items()}
        found = {p: one for p, one in known.items() if isinstance(one, float) and one > least}
        if found:
            worst = max(found, key=lambda place: found[place])
            most = sentence.format(found[worst])
            yield f"{worst}: {most}; scores are limited so in {len(found)} of {len(facts)} cases."
