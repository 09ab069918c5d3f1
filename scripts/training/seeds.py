"""Several trainings that differ by their seed alone, and their common report."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ...checks import at_least
from ...envs.evaluation.statistics import interquartile_mean, interquartile_mean_interval
from ...envs.policies.trained import training_of
from ...errors import InputError, shown
from ..backends import run_all
from ..folders import RunFolder
from ..writer import Report, conclude
from .evaluations import read_evaluations, relief_text, value
from .report import learning_plot
from .request import TrainingRequest

MOST = 1000  # greatest number of seeds
HIGHEST = 2**32 - 1  # largest seed for the generators of all learners
FEWEST = 5  # least number of trainings for an interval


def seeds_of(text: str) -> list[int]:
    """Returns the seeds of a text such as "0-9" or "0,3,5", each once and in order."""
    found: set[int] = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*([0-9]{1,10})(?:-([0-9]{1,10}))?\s*", part)
        low, high = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if not 0 <= high - low < MOST:
            raise InputError(
                f"--seeds is {shown(text)}: give whole numbers, as 0-9 or 0,3,5, the lowest of "
                f"each part first and at most {MOST}"
            )
        at_least("seed", high, 0, HIGHEST)
        found |= {*range(low, high + 1)}
    return sorted(found)


def train_all(request: TrainingRequest, seeds: Sequence[int], out: Path, workers: int) -> None:
    """Trains with each seed in a folder of its own, and reports all of them together."""
    folder = RunFolder(out, force=request.force, resumes=request.resume)
    runs = {seed: folder.subfolder(f"seed-{seed}") for seed in seeds}
    given = [(path, seed) for seed, path in runs.items()]
    for _ in run_all(request.seed, given, "loky", workers):  # one worker is this process
        pass
    found = {seed: read_evaluations(path) for seed, path in runs.items()}
    curves = {f"seed {seed}": one["results"] for seed, one in found.items()}
    beside = found[seeds[0]].get("beside", {})  # the motions are the same for all seeds
    best = {seed: max(one["results"], key=value) for seed, one in found.items()}
    steps = sorted({training_of(path)["steps"] for path in runs.values()})
    rows = [
        [str(seed), str(one["steps"]), relief_text(one["relief"]), f"{one['success']:.0%}"]
        for seed, one in best.items()
    ]
    reliefs = [value(one) for one in best.values()]
    together = over_trainings(reliefs) if np.isfinite(reliefs).all() else None
    report = Report(
        heading="Trained policies",
        about=f"{len(seeds)} seeds",
        result={"best": {str(seed): one for seed, one in best.items()}, "together": together},
        tables={"trainings": (["seed", "steps of the best", "relief", "success"], rows)},
        answer=[*_remarks(together, steps)],
        plots={"learning_curves": learning_plot(curves, beside)},
        settings={"seeds": seeds, "steps": steps},
    )
    conclude(report, folder)


def over_trainings(reliefs: Sequence[float]) -> dict[str, float]:
    """Returns the interquartile mean over trainings, with an interval for five or more."""
    scores = np.array(reliefs, float)
    if len(scores) < FEWEST:
        return {"value": float(interquartile_mean(scores))}
    return interquartile_mean_interval(scores[:, None]).to_dict()


def _remarks(together: dict[str, float] | None, steps: list[int]) -> Iterator[str]:
    if len(steps) > 1:
        yield f"the trainings differ: they were asked for {' and '.join(map(str, steps))} steps"
    if together is None:
        yield "a training has no relief, so that they are not summed up"
    else:
        more = "" if "low" in together else f"; give at least {FEWEST} seeds for an interval"
        yield f"interquartile mean of the relief {relief_text(together)} over trainings{more}"
    yield "relief is of adapted wearers in motions that are in no training"
