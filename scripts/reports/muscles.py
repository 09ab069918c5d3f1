"""Muscles of evaluated motions: tables, remarks and plain values (needs the extra `muscles`)."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...envs.evaluation import REFERENCES, Evaluation, Interval
from ...envs.muscles import STANDARD, MuscleScore, muscle_relief, muscle_scores, relief_range
from ..output import Rows, progress

Scores = Mapping[str, MuscleScore]


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
    header = ["policy", "power\n[W]", "active\n[%]"]
    if _has_references(scores):
        header += ["relief of\npower", "its\nrange", "relief of\nactivation"]
    rows = []
    for name, score in scores.items():
        cells = [name, f"{np.mean(score.power[STANDARD]):.1f}"]
        cells += [f"{100 * float(np.mean(score.effort[STANDARD])):.1f}"]
        if _has_references(scores):
            between = relief_range(*_three(scores, name))
            cells += [_two_lines(muscle_relief(*_three(scores, name)))]
            cells += ["-" if between is None else f"{between[0]:.2f}\nto {between[1]:.2f}"]
            cells += [_two_lines(muscle_relief(*_three(scores, name), "effort"))]
        most = "\n".join(f"{muscle} {100 * load:.0f}" for muscle, load in score.loaded.items())
        rows.append([*cells, most])
    return [*header, "most loaded\n[%]"], rows


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
        if score.saturated > 0:
            yield (
                f"{name}: a muscle is fully active in {score.saturated:.1%} of the time, so that "
                "its load may be larger than these numbers."
            )
        if score.outside > 0:
            yield (
                f"{name}: {score.outside:.1%} of the postures are outside the ranges of MyoArm's "
                "joints."
            )
        if score.reserve > 0.01:
            yield (
                f"{name}: muscles cannot give {score.reserve:.1%} of the torque, in one sample "
                f"{score.largest_reserve:.1f} N·m."
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
