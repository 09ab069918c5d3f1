"""Several trainings that differ by their seed alone, and what they say together."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...checks import at_least
from ...envs.evaluation.statistics import interquartile_mean, interquartile_mean_interval
from ...envs.policies.trained import training_of
from ...errors import InputError
from ..backends import run_all
from ..conclusion import conclude
from ..output import RunFolder
from ..reports.learning import learning_figure
from .evaluations import read_evaluations, relief_text, value

MOST, LONGEST = 1000, 40  # seeds, and characters of a pair of them
HIGHEST = 2**32 - 1  # seed that the generators of all learners take
FEWEST = 5  # trainings from which an interval can be had
Train = Callable[[Path, int], None]


def seeds_of(text: str) -> list[int]:
    """Returns seeds from "0-9" or "0,3,5", each once and in order."""
    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()) or len(part) > LONGEST:
            raise InputError(f"--seeds is {text!r}: give whole numbers, as 0-9 or 0,3,5")
        low, high = int(first), int(last) if dash else int(first)
        if not 1 <= high - low + 1 <= MOST:
            raise InputError(f"--seeds has {part.strip()!r}: give 1 to {MOST} seeds, lowest first")
        at_least("seed", high, 0, HIGHEST)
        found += range(low, high + 1)
    if len(set(found)) < len(found):
        raise InputError(f"--seeds is {text!r}, which has a seed twice: give each once")
    return sorted(found)


def train_all(
    train: Train,
    seeds: list[int],
    out: Path,
    workers: int,
    *,
    resume: bool,
    force: bool,
) -> None:
    """Trains with each seed in a folder of its own, and reports all of them together.

    Args:
        train: Function that trains in a folder with a seed, or continues what is there.
        seeds: The seeds.
        out: Folder of the folders.
        workers: Number of trainings at once.
        resume: Whether to go on with what is there.
        force: Whether to replace what is there.
    """
    folder = RunFolder(out, force=force, resumes=resume)
    runs = {seed: folder.subfolder(f"seed-{seed}") for seed in seeds}
    given = [(path, seed) for seed, path in runs.items()]
    if workers == 1:
        for path, seed in given:
            train(path, seed)
    else:
        for _ in run_all(train, given, "loky", workers):
            pass
    results = {seed: read_evaluations(path) for seed, path in runs.items()}
    curves = {f"seed {seed}": one["results"] for seed, one in results.items()}
    folder.figure("learning_curves", learning_figure(curves))
    best = {seed: max(one["results"], key=value) for seed, one in results.items()}
    steps = sorted({training_of(path)["steps"] for path in runs.values()})
    rows = [
        [str(seed), str(one["steps"]), relief_text(one["relief"]), f"{one['success']:.0%}"]
        for seed, one in best.items()
    ]
    header = ["seed", "steps of the best", "relief", "success"]
    conclude(
        "train",
        {"best": {str(seed): one for seed, one in best.items()}, "together": together(best)},
        {"trainings": (header, rows)},
        _remarks(best, steps),
        folder=folder,
        json=False,
        settings={"seeds": seeds, "steps": steps},
    )


def together(best: dict[int, dict[str, Any]]) -> dict[str, float] | None:
    """Returns what `over_trainings` does of the relief; None where a training has none."""
    reliefs = [value(one) for one in best.values()]
    return over_trainings(reliefs) if np.isfinite(reliefs).all() else None


def over_trainings(reliefs: Sequence[float]) -> dict[str, float]:
    """Returns the interquartile mean over trainings, with its interval from five trainings on.

    Args:
        reliefs: Relief of each training, a mean over motions.
    """
    scores = np.array(reliefs, float)
    if len(scores) < FEWEST:
        return {"value": float(interquartile_mean(scores))}
    return interquartile_mean_interval(scores[:, None]).to_dict()


def _remarks(best: dict[int, dict[str, Any]], steps: list[int]) -> Iterator[str]:
    if len(steps) > 1:
        yield f"the trainings differ: they were asked for {' and '.join(map(str, steps))} steps"
    found = together(best)
    if found is None:
        yield "a training has no relief, so that they are not summed up"
    else:
        more = "over trainings"
        if "low" not in found:
            more = f"over trainings; give at least {FEWEST} seeds for an interval"
        yield f"interquartile mean of the relief {relief_text(found)} {more}"
    yield "relief is of adapted wearers in motions that are in no training"
