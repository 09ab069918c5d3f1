"""What the report of each command shows: a heading, and sections with figures."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...envs.benchmark.results import RESULTS, read_results
from ...envs.benchmark.standings import FIXED, Standings
from ...envs.evaluation import REFERENCES
from ...errors import InputError
from ...json_files import read_json
from .blocks import Block, Chart, Picture, Section
from .charts import COLORS, GRAY, band, intervals, line, plain
from .contents import Contents
from .loops import loop_charts
from .motions import motion_blocks

MOTION_PICTURES = {
    "trajectory": "Intended and actual angles",
    "torques": "Torques over time",
    "motion-loops": "Torques over angle",
    "strain": "Effort, fatigue and heat",
    "cuff-forces": "Forces of the cuffs",
}
SCORE = "score-"  # begins the name of a picture of an extra
NO_CHART = ("strain", "cuff-forces")  # of these a page has the picture in any case
Blocks = Callable[[Path, Contents], Iterator[Section]]


class Subject(NamedTuple):
    """What a report is about.

    Attributes:
        command: Command, as it is typed.
        heading: Title of the page.
        sections: Function that yields sections with figures from the files of the run.
    """

    command: str
    heading: str
    sections: Blocks


def _none(folder: Path, contents: Contents) -> Iterator[Section]:
    del folder, contents
    yield from ()


def _loops(folder: Path, contents: Contents) -> Iterator[Section]:
    del contents
    still = Picture(name="loops.png", title="Loops", instead=True)
    yield Section(title="Loops", blocks=[*loop_charts(folder), still])


def _motions(folder: Path, contents: Contents) -> Iterator[Section]:
    pictures = [
        Picture(name=f"{name}{place}.png", title=f"{title}{place}", instead=name not in NO_CHART)
        for place in ("", *(f"-{one}" for one in dict.fromkeys(m.place for m in contents.motions)))
        for name, title in MOTION_PICTURES.items()
    ]
    matrix = Picture(name="matrix.png", title="Torque error by believed and true suit")
    blocks: list[Block] = [matrix, *motion_blocks(folder, contents), *pictures]
    yield Section(title="Motions", blocks=blocks)


def _evaluate(folder: Path, contents: Contents) -> Iterator[Section]:
    """Yields relief with its intervals, then the first motions; many settings have tables alone."""
    path = folder / "result.json"
    result = read_json(path, "result")
    try:
        scores = result.get("scores", {})
        reliefs = {name: one["relief"] for name, one in scores.items() if one.get("relief")}
        names = [name for name in reliefs if name not in REFERENCES]
        value, low, high = _ends([reliefs[name] for name in names])
    except (AttributeError, TypeError, KeyError, ValueError) as error:
        raise InputError(f"{str(path)!r} holds no evaluation: restore it") from error
    if names:
        layout = plain("relief: 0 is the suit alone, 1 is no suit", "", 110 + 34 * len(names))
        layout["yaxis"] |= {"autorange": "reversed", "type": "category"}
        chart = Chart(
            title="Relief, with its 95 % interval",
            text=f"Relief of {', '.join(names)} with intervals; the numbers are in the tables.",
            data=[intervals(names, value, low, high, COLORS[0])],
            layout=layout,
        )
        yield Section(title="Relief", blocks=[chart])
    drawn = sorted(path.name for path in folder.glob(f"{SCORE}*.png"))
    pictures = [Picture(name=one, title=one.removesuffix(".png")) for one in drawn]
    yield Section(title="Scores of extras", blocks=pictures)
    yield from _motions(folder, contents)


def _ends(found: list[dict[str, float]]) -> tuple[Array, Array, Array]:
    """Returns values and ends of intervals."""
    value, low, high = (
        np.array([one[part] for one in found], float) for part in ("value", "low", "high")
    )
    return value, low, high


def _demo(folder: Path, contents: Contents) -> Iterator[Section]:
    yield from _loops(folder, contents)
    arm = Picture(name="arm.png", title="The person, the suit and the exoskeleton")
    convergence = Picture(name="convergence.png", title="How the swarms converge")
    yield Section(title="Pictures", blocks=[convergence, arm])
    yield from _motions(folder, contents)


def _learning(folder: Path, contents: Contents) -> Iterator[Section]:
    """Yields the learning curve of a training, or of several with other seeds."""
    del contents
    name = "evaluations.json"
    paths = sorted(folder.glob(f"seed-*/{name}")) or [folder / name]
    data = []
    for path, color in zip(paths, COLORS * len(paths), strict=False):
        if not path.is_file():
            continue
        label = path.parent.name.replace("-", " ") if path.parent != folder else "relief"
        found = read_json(path, "evaluations")
        try:
            results = [one for one in found["results"] if one["relief"]]
            steps = np.array([one["steps"] for one in results], float)
            value, low, high = _ends([one["relief"] for one in results])
        except (TypeError, KeyError, ValueError) as error:
            raise InputError(f"{str(path)!r} holds no evaluations: restore it") from error
        data.append(band(steps, low, high, "interval", color, group=label))
        data.append(line(steps, value, label, color, group=label))
    if data:
        chart = Chart(
            title="Relief of adapted wearers during the training",
            text="Relief over steps of the training, with the 95 % interval of each evaluation.",
            data=data,
            layout=plain("steps", "relief", 380),
        )
        name = "learning_curve.png" if len(paths) == 1 else "learning_curves.png"
        still = Picture(name=name, title="Learning curve", instead=True)
        yield Section(title="Learning curve", blocks=[chart, still])


def _profiles(folder: Path, contents: Contents) -> Iterator[Section]:
    """Yields performance profiles: the share of motions with at least a relief."""
    del contents
    standings = Standings(read_results((folder / RESULTS,)))
    relief = np.linspace(-1.0, 1.5, 126)
    blocks: list[Block] = []
    for level in standings.levels:
        names = [name for name in standings.policies_at(level) if name not in FIXED[:2]]
        data = []
        for name, own in zip(names, COLORS * len(names), strict=False):
            bound = name == FIXED[2]
            found = np.asarray(standings.profile(name, level, relief))
            color, dash = (GRAY, "dash") if bound else (own, "solid")
            data.append(line(relief, found, name, color, dash=dash))
        blocks.append(
            Chart(
                title=f"{level}: share of motions with at least a relief",
                text=f"Share of motions at level {level} over the relief that they reach at least, "
                f"for {', '.join(names)}.",
                data=data,
                layout=plain("relief", "share of motions", 420),
            )
        )
    still = Picture(name="profiles.png", title="Profiles", instead=True)
    yield Section(title="Profiles", blocks=[*blocks, still])


SUBJECTS = {
    "demo": Subject("demo", "From measured loops to a compensated arm motion", _demo),
    "identify": Subject("identify", "Identified model", _loops),
    "rig": Subject("rig", "Measured on the simulated rig", _loops),
    "simulate": Subject("simulate", "Simulated motion", _motions),
    "evaluate": Subject("evaluate", "Policies compared", _evaluate),
    "validate": Subject("validate", "Validation of a suit model", _motions),
    "benchmark": Subject("benchmark run", "Benchmark of controllers", _profiles),
    "benchmark-table": Subject("benchmark table", "Benchmark of controllers", _profiles),
    "train": Subject("train", "Trained policy", _learning),
    "bench honesty": Subject("bench honesty", "How often verdicts are right", _none),
}
