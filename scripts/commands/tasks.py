"""`activesuit tasks`: lists the tasks, or measures how difficult each is."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from json import loads
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ... import __version__
from ...checks import at_least, check_seed
from ...envs.evaluation import FIRST_SEED, Evaluation, evaluate
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.levels import COMPARED, LEVELS
from ...envs.tasks import TASKS, Task
from ...errors import InputError, unknown_name
from ...json_files import read_json
from ..conclusion import conclude
from ..options import Force, Json, choice
from ..output import Rows, RunFolder, markdown_table, progress, say, to_json
from ..output import table as print_table

WRONG = {"nominal": "emu-like", "randomized": "emu-like", "shift": "mock-suit"}
"""Suit in which the controller with the wrong model believes, at each level."""
SHOWN = ("unsuited", "suited", "none", "right model", "wrong model", "best-known-plan")
MOST = 0.9  # share of motions that must succeed for a task to be within reach of a wearer


def tasks(
    only: tuple[Annotated[str, choice(lambda: TASKS)], ...] = (),
    levels: tuple[Annotated[str, choice(lambda: LEVELS)], ...] = COMPARED,
    table: bool = False,
    episodes: int = 20,
    seed: int = FIRST_SEED,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """List the tasks, or measure how difficult each is.

    Difficulty is what is reached without assistance, by compensation with the right and with the
    wrong model of the suit, and by the best known plan.

    Args:
        only: Names of tasks; by default all.
        levels: Levels at which difficulty is measured.
        table: Measure difficulty, which takes about a minute per task and level.
        episodes: Number of motions of each policy, at least 8.
        seed: Seed of the first motion.
        out: Folder for tasks.md, result.json and what is finished so far, so that the same command
            goes on after an interruption.
    """
    for what, names, known in (("task", only, TASKS), ("level", levels, LEVELS)):
        for name in names:
            if name not in known:
                raise unknown_name(what, name, known)
    chosen = {name: TASKS[name] for name in only or TASKS}
    if not table:
        usual = (COMPARED, 20, FIRST_SEED, None)
        if (tuple(levels), episodes, seed, out) != usual:
            raise InputError("--levels, --episodes, --seed and --out belong to --table: add it")
        _list(chosen, json)
        return
    at_least("episodes", episodes, FEWEST_MOTIONS)
    check_seed(seed)
    folder = RunFolder(out, force=force) if out else None
    settings = [(name, level) for name in chosen for level in levels]
    found: dict[tuple[str, str], dict[str, Any]] = {}
    with progress("tasks", len(settings)) as bar:
        for name, level in settings:
            found[name, level] = _finished(folder, name, level, episodes, seed)
            bar.advance()
    rows = difficulty_table(found)
    tables = {f"Success and relief, {episodes} motions": rows}
    if folder:
        folder.text("tasks.md", markdown_table(*rows) + "\n")
    result = {"episodes": episodes, "seed": seed, "settings": list(found.values())}
    conclude(result, tables, _remarks(found), folder=folder, json=json)


def difficulty(task: str, level: str, episodes: int, seed: int) -> Evaluation:
    """Returns scores of the policies that tell how difficult a task is.

    Args:
        task: Name of the task.
        level: Name of the level.
        episodes: Number of motions.
        seed: Seed of the first one.
    """
    return evaluate(
        f"ActiveSuit/{task}-v0",
        {
            "none": "none",
            "right model": "compensation",
            "wrong model": {"name": "compensation", "suit": WRONG[level]},
            "best-known-plan": "best-known-plan",
        },
        episodes=episodes,
        seed=seed,
        level=level,
        threads=0,
    )


def difficulty_table(found: Mapping[tuple[str, str], Mapping[str, Any]]) -> Rows:
    """Returns a row per task and level: share of success, and relief where it has a meaning."""
    header = ["task", "level", *SHOWN]
    rows = []
    for (task, level), setting in found.items():
        scores = setting["scores"]
        rows.append([task, level, *(_cell(scores[name], name) for name in SHOWN)])
    return header, rows


def _cell(score: Mapping[str, Any], name: str) -> str:
    success, relief = f"{100 * float(np.mean(score['success'])):.0f} %", score["relief"]
    if name in ("unsuited", "suited") or relief is None:
        return success
    return f"{success}\n{relief['value']:.2f}"


def _remarks(found: Mapping[tuple[str, str], Mapping[str, Any]]) -> Iterator[str]:
    for (task, level), setting in found.items():
        unsuited, best = (
            float(np.mean(setting["scores"][name]["success"]))
            for name in ("unsuited", "best-known-plan")
        )
        if unsuited < MOST:
            yield (
                f"{task} at {level} is beyond the wearer even unsuited in "
                f"{100 * (1 - unsuited):.0f} % of the motions."
            )
        elif best < MOST:
            yield (
                f"{task} at {level}: motors that know everything succeed in {100 * best:.0f} % of "
                "the motions."
            )


def _finished(
    folder: RunFolder | None, task: str, level: str, episodes: int, seed: int
) -> dict[str, Any]:
    """Returns the result of a setting, from the folder where it is there."""
    name = f"{task}-{level}.json"
    key = {
        **{"version": __version__, "episodes": episodes, "seed": seed, "level": level},
        **{"options": LEVELS[level], "task": asdict(TASKS[task])},
    }
    key = _plain(key)
    if folder and folder.own and (folder / name).exists():
        kept = read_json(folder / name, "result of a task")
        if isinstance(kept, dict) and kept.get("key") == key:
            return kept
    result = {"key": key, **_plain(difficulty(task, level, episodes, seed).to_dict())}
    if folder:
        folder.json(name, result)
    return result


def _plain(value: Any) -> Any:
    """Returns a value as JSON would give it back."""
    return loads(to_json(value))


def _list(chosen: Mapping[str, Task], json: bool) -> None:
    if json:
        print(
            to_json(
                {
                    name: {
                        **asdict(task),
                        **{"id": f"ActiveSuit/{name}-v0", "place": task.place},
                        **{"about": task.about, "source": task.source, "rule": task.rule},
                    }
                    for name, task in chosen.items()
                }
            )
        )
        return
    rows = [
        [f"ActiveSuit/{name}-v0", f"{task.duration:g} s", task.place, task.about]
        for name, task in chosen.items()
    ]
    print_table("tasks", ["id", "duration", "place", "motion and load"], rows, left=4)
    for name, task in chosen.items():
        say(f"{name} succeeds with {task.rule}. Source: {task.source}.")
