"""Muscles of evaluated motions and of the benchmark: tables, remarks and plain values."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ...envs.benchmark import Result, Setting
from ...envs.benchmark.muscles import muscle_measure, muscle_standing
from ...envs.benchmark.standings import Standings
from ...envs.evaluation import REFERENCES, Evaluation, Interval
from ...envs.muscles import STANDARD, MuscleScore, muscle_relief, muscle_scores, relief_range
from ..output import Rows, progress

Scores = Mapping[str, MuscleScore]
COSTS = ("power\n[W]", "active\n[%]")
RELIEFS = ("relief of\npower", "its\nrange", "relief of\nactivation")
LOADED = "most loaded\n[%]"
TIRES = (
    "--muscles scales MyoArm by one factor, and this wearer tires: choose another task, or --set "
    "fatigue=false"
)
LIMITS = {
    "saturated": (
        0.0,
        "a muscle is fully active in {saturated:.1%} of the time, so that its load may be larger "
        "than these numbers.",
    ),
    "outside": (0.0, "{outside:.1%} of the postures are outside the ranges of MyoArm's joints."),
    "reserve": (
        0.01,
        "muscles cannot give {reserve:.1%} of the torque, in one sample {largest_reserve:.1f} N·m.",
    ),
}
"""What limits a score: the value from which on it is said, and how."""


def scored(evaluation: Evaluation) -> dict[str, MuscleScore]:
    """Returns the muscles of every policy of an evaluation, and shows how far it is."""
    motions = sum(len(one) for one in evaluation.traces.values())
    with progress("muscles", motions) as bar:
        return {
            name: muscle_scores(one, on_motion=bar.advance)
            for name, one in evaluation.traces.items()
        }


def muscle_values(scores: Scores) -> dict[str, Any]:
    """Returns scores and reliefs as plain values, by policy."""
    found = {}
    for name, score in scores.items():
        reliefs = {}
        for what in ("power", "effort") if _has_references(scores) else ():
            relief = muscle_relief(*_three(scores, name), what)
            reliefs[f"{what}_relief"] = relief and relief.to_dict()
            reliefs[f"{what}_relief_range"] = relief_range(*_three(scores, name), what)
        found[name] = {**score.to_dict(), **reliefs}
    return found


def muscle_table(scores: Scores) -> Rows:
    """Returns one row per policy: metabolic power, activation, relief, and the most loaded.

    The range of relief is that over all conventions.
    """
    rows = []
    for name, score in scores.items():
        power, effort = (float(np.mean(one[STANDARD])) for one in (score.power, score.effort))
        reliefs = []
        if _has_references(scores):
            three = _three(scores, name)
            reliefs = _relief_cells(
                muscle_relief(*three), relief_range(*three), muscle_relief(*three, "effort")
            )
        rows.append([name, *_cost_cells(power, effort), *reliefs, _loaded(score.loaded)])
    return ["policy", *COSTS, *(RELIEFS if _has_references(scores) else ()), LOADED], rows


def muscle_level_rows(standings: Standings, level: str) -> Rows:
    """Returns the same row per policy over all tasks of a level of the benchmark."""
    settings, rows = standings.settings_at(level), []
    for name in standings.policies_at(level):
        one = muscle_standing(standings, name, settings)
        if one is None:
            rows.append([name, *["-"] * (len(COSTS) + len(RELIEFS) + 1)])
            continue
        reliefs = _relief_cells(one.power_relief, one.power_relief_range, one.effort_relief)
        rows.append([name, *_cost_cells(one.power, one.effort), *reliefs, _loaded(one.loaded)])
    return ["policy", *COSTS, *RELIEFS, LOADED], rows


def muscle_task_rows(standings: Standings, level: str) -> Rows:
    """Returns a row per policy: its metabolic power and mean relief in each setting of a level."""
    settings = standings.settings_at(level)
    header = ["policy", *(f"{s.task}\n{s.believed}" for s in settings)]
    names = standings.policies_at(level)
    return header, [[name, *(_cell(standings, s, name) for s in settings)] for name in names]


def _cell(standings: Standings, setting: Setting, policy: str) -> str:
    found = standings.of(setting, policy)
    if found is None or found.muscles is None:
        return "failed" if found is not None and found.failed else "-"
    power = f"{np.mean(found.muscles.power[STANDARD]):.1f} W"
    relief = standings.relief(setting, policy, of=muscle_measure("power"))
    return power if relief is None else f"{power}\n{np.mean(relief):.2f}"


def _cost_cells(power: float, effort: float) -> list[str]:
    return [f"{power:.1f}", f"{100 * effort:.1f}"]


def _relief_cells(
    power: Interval | None, between: tuple[float, float] | None, effort: Interval | None
) -> list[str]:
    within = "-" if between is None else f"{between[0]:.2f}\nto {between[1]:.2f}"
    return [_two_lines(power), within, _two_lines(effort)]


def _loaded(loaded: Mapping[str, float]) -> str:
    return "\n".join(f"{muscle} {100 * load:.0f}" for muscle, load in loaded.items())


def _two_lines(interval: Interval | None) -> str:
    if interval is None:
        return "-"
    return f"{interval.value:.2f}\n{interval.low:.2f} to {interval.high:.2f}"


def muscle_remarks(scores: Scores) -> Iterator[str]:
    """Yields sentences: what the muscles cost, and what limits the numbers."""
    if _has_references(scores):
        unsuited, suited = (np.mean(scores[name].power[STANDARD]) for name in REFERENCES)
        yield (
            f"Muscles: the suit changes the metabolic power of the arm from {unsuited:.1f} to "
            f"{suited:.1f} W, of which {scores['suited'].rest:.1f} W are rest."
        )
    for name, score in scores.items():
        for limit, (least, sentence) in LIMITS.items():
            if getattr(score, limit) > least:
                yield f"{name}: {sentence.format_map(vars(score))}"


def benchmark_muscle_remarks(results: Sequence[Result]) -> Iterator[str]:
    """Yields sentences: which trials have no muscles and why, and what limits the numbers."""
    without = sum(not (one.asked_for_muscles or one.failed) for one in results)
    if without:
        yield (
            f"note: {without} of {len(results)} trials were run without --muscles, and have none "
            "in these tables"
        )
    reasons: dict[str, str] = {}
    for one in results:
        if one.no_muscles is not None:
            reasons.setdefault(one.task, one.no_muscles)
    for task, reason in reasons.items():
        yield f"note: muscles cannot be scored in {task}: {reason}"
    scored = [one for one in results if one.muscles is not None]
    for limit, (least, sentence) in LIMITS.items():
        found = [one for one in scored if getattr(one.muscles, limit) > least]
        if found:
            worst = max(found, key=lambda one: getattr(one.muscles, limit))
            yield (
                f"muscles in {len(found)} of {len(scored)} trials, the most in {worst.policy} in "
                f"{worst.task} at {worst.level}: {sentence.format_map(vars(worst.muscles))}"
            )


def shown_motions(evaluation: Evaluation, scores: Scores) -> list[str]:
    """Returns the names of the conditions to draw: in the suit alone, and with the best policy."""
    power = {
        name: float(np.nan_to_num(np.mean(score.power[STANDARD]), nan=np.inf))
        for name, score in scores.items()
        if name not in REFERENCES
    }
    best = min(power, key=power.__getitem__)
    return [name for name in (REFERENCES[1], best) if name in evaluation.traces]


def _has_references(scores: Scores) -> bool:
    return all(name in scores for name in REFERENCES)


def _three(scores: Scores, name: str) -> tuple[MuscleScore, MuscleScore, MuscleScore]:
    unsuited, suited = (scores[reference] for reference in REFERENCES)
    return unsuited, suited, scores[name]
