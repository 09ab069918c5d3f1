"""`activesuit benchmark learning`: ways of training over tasks, levels and seeds."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from ...checks import at_least
from ...envs.evaluation.core import FIRST_SEED, REFERENCES, run
from ...envs.evaluation.relief import relief
from ...envs.evaluation.wearers import ArmLost
from ...envs.levels import COMPARED
from ...envs.policies import policy_spec
from ...envs.policies.build import residual_of
from ...envs.policies.network import CARD
from ...envs.policies.residual import SCALE
from ...envs.policies.trained import training_of
from ...errors import InputError, unknown_name
from ...json_files import Model, modelled, read_json
from ..arm_options import USUAL
from ..backends import run_all
from ..conclusion import conclude
from ..options import Force, Json, choice, optional_number
from ..options import levels as level_names
from ..options import shipped_tasks as task_names
from ..output import RunFolder, progress
from ..reports.learning import study_figure
from ..runs import scene
from ..training.evaluations import FIRST, MOTIONS, read_evaluations, relief_text
from ..training.hyperparameters import ALGORITHMS
from ..training.request import MOST_STEPS, TrainingRequest
from ..training.seeds import over_trainings, seeds_of

COMPENSATION = "compensation:suit=mock-suit"
BESIDE = (COMPENSATION, "adaptive:suit=mock-suit", "best-known-plan")
WAYS: dict[str, dict[str, Any]] = {
    **{algo: {"algo": algo} for algo in ALGORITHMS},
    "ppo-history": {"algo": "ppo", "history": 5},
    "residual": {"algo": "ppo", "residual": COMPENSATION},
    "residual-history": {"algo": "ppo", "residual": COMPENSATION, "history": 5},
    "residual-guided": {"algo": "ppo", "residual": COMPENSATION, "control": {"stiff": True}},
    "residual-drawn": {
        "algo": "ppo",
        "residual": COMPENSATION,
        "history": 5,
        "level": "randomized",
        "randomize": {"suits": ["mock-suit", "emu-like"]},
    },
    "student": {"teacher": "adaptive:suit=mock-suit", "history": 10},
}
USUAL_STEPS = 200_000
STEPS = {  # of ways with another number
    "sac": 40_000,
    "tqc": 40_000,
    "recurrent-ppo": 300_000,
    "student": 1_000_000,
}
TASKS = ("ArmTracking", "RangeOfMotion", "ObjectRelocation")
TESTED = range(FIRST_SEED, FIRST_SEED + 20)  # motions of a finished policy
IN_TRAINING = range(FIRST, FIRST + MOTIONS)
SCORE = "score.json"


class Score(BaseModel):
    """What a policy gave in the test.

    Attributes:
        steps: Number of steps of its training; 0 of a policy that has none.
        effort: Effort of each motion; None where an arm was lost.
        success: Share of the motions with success.
    """

    steps: int = 0
    effort: list[float] | None
    success: float


class Beside(BaseModel):
    """Scores of references, policies and the bound in a setting, in two sets of motions."""

    tested: dict[str, Score]
    in_training: dict[str, Score]


class Cell(NamedTuple):
    """A way of training in a task at a level."""

    task: str
    level: str
    way: str

    @property
    def folder(self) -> str:
        """Name of the folder of its trainings."""
        return "-".join(self)


def learning(
    ways: tuple[Annotated[str, choice(lambda: WAYS)], ...] = tuple(WAYS),
    tasks: tuple[Annotated[str, choice(task_names)], ...] = TASKS,
    levels: tuple[Annotated[str, choice(level_names)], ...] = COMPARED,
    seeds: str = "0-9",
    steps: Annotated[int | None, optional_number("that of the way", int)] = None,
    workers: int = -1,
    out: Path = Path("runs/learning"),
    force: Force = False,
    json: Json = False,
) -> None:
    """Compare ways of training over tasks, levels and seeds.

    Each training is a run of `activesuit train` at the level at which its policy is tested; only
    residual-drawn always trains at level randomized. The tests use seeds that no training uses.
    The same command again does what is left. Where an arm is lost in a test, there is no relief.

    Args:
        ways: Names of ways of training: an algorithm alone; ppo-history observes five control
            periods; residual corrects compensation that believes the suit mock-suit, and
            residual-history does so with five control periods; residual-guided has wearers who are
            guided along the intention; residual-drawn is residual-history with suits drawn from
            mock-suit and emu-like; student repeats adaptive.
        tasks: Names of tasks.
        levels: Names of levels.
        seeds: Seeds of the trainings, as 0-9 or 0,3,5.
        steps: Number of environment steps of each training, by default 40,000 of sac and tqc,
            300,000 of recurrent-ppo, 1,000,000 of student and 200,000 of others.
        workers: Number of trainings at once; -1 uses all cores.
        out: Folder of the trainings, result.json and the figure of learning curves.
    """
    for way in ways:
        if way not in WAYS:
            raise unknown_name("way of training", way, WAYS)
    for task in tasks:
        if task not in task_names():
            raise unknown_name("task", task, task_names())
    if workers != -1:
        at_least("workers", workers, 1)
    if steps is not None:
        at_least("steps", steps, 1, MOST_STEPS)
    chosen = seeds_of(seeds)
    cells = [Cell(*names) for names in product(tasks, levels, ways)]
    folder = RunFolder(out, "benchmark learning", force=force)
    runs = {
        (cell, seed): folder.subfolder(cell.folder) / f"seed-{seed}"
        for cell, seed in product(cells, chosen)
    }
    settings = list(product(tasks, levels))
    files = {one: folder / f"{'-'.join(one)}.json" for one in settings}
    work: list[tuple[Any, ...]] = [
        (_beside, one, folder, path.name) for one, path in files.items() if not path.exists()
    ]
    for (cell, seed), path in runs.items():
        many = steps or STEPS.get(cell.way, USUAL_STEPS)
        asked = _steps(path)
        if asked not in (None, many) and not force:
            raise InputError(
                f"a training has {many} steps, and the one in {str(path)!r} {asked}: give --steps "
                f"{asked}, another --out, or --force to train anew"
            )
        score = path / SCORE
        if not score.is_file() or _read(score, Score).steps != many:
            work.append((_train, cell, seed, path, many))
    with progress("learning", len(work)) as bar:
        for _ in run_all(_call, work, "loky", workers):
            bar.advance()
    beside = {one: _read(path, Beside) for one, path in files.items()}
    result = _result(cells, chosen, runs, beside)
    folder.figure("learning", study_figure(result["curves"], result["beside"]))
    conclude(
        result,
        {"relief at the end (interquartile mean over trainings)": _table(result)},
        ["relief is of adapted wearers in 20 motions that no training and no choice has used"],
        folder=folder,
        json=json,
    )


def _read(path: Path, model: type[Model]) -> Model:
    return modelled(read_json(path, "scores"), model, str(path), "file of scores", "remove it")


def _call(function: Any, *arguments: Any) -> None:
    function(*arguments)


def _train(cell: Cell, seed: int, path: Path, steps: int) -> None:
    """Trains in a folder, or continues what is there, and tests the policy that is kept.

    A training of another number of steps begins anew, as its learning rate has fallen to 0.
    """
    given = {"level": cell.level, "steps": steps, **WAYS[cell.way]}
    if "residual" in given:
        given["residual"] = residual_of(given["residual"], SCALE)
    again = _steps(path) == steps
    request = TrainingRequest(given=given, scene=_scene(cell.task), resume=again, force=True)
    request.seed(path, seed)
    score = _tested(str(path), cell.task, cell.level)
    RunFolder(path).json(SCORE, {**score.model_dump(), "steps": steps})


def _steps(path: Path) -> int | None:
    """Returns the steps that the training in a folder was asked for; None if there is none."""
    return training_of(path).get("steps") if (path / CARD).exists() else None


def _beside(setting: tuple[str, str], folder: RunFolder, name: str) -> None:
    """Tests references, policies and the bound in a setting."""
    motions = {"tested": TESTED, "in_training": IN_TRAINING}
    found = {
        part: {one: _tested(one, *setting, seeds).model_dump() for one in (*REFERENCES, *BESIDE)}
        for part, seeds in motions.items()
    }
    RunFolder(folder.path).json(name, found)


def _scene(task: str) -> Any:
    return partial(scene, USUAL, env=None, task=task, suit=None, gravity=None)


def _tested(
    name: str,
    task: str,
    level: str,
    seeds: Sequence[int] = TESTED,
) -> Score:
    found = _scene(task)(level=level)
    given = name if name in (*REFERENCES, "best-known-plan") else policy_spec(name)
    try:
        score = run(name, given, found.env, seeds, **found.options).score
    except ArmLost:
        return Score(effort=None, success=0.0)
    return Score(effort=list(map(float, score.effort)), success=float(np.mean(score.success)))


def _result(
    cells: list[Cell],
    seeds: list[int],
    runs: Mapping[tuple[Cell, int], Path],
    beside: Mapping[tuple[str, str], Beside],
) -> dict[str, Any]:
    """Returns the relief of each way, and of what stands beside it, as plain data."""
    curves, ends, others = [], [], []
    for cell in cells:
        names = {"task": cell.task, "level": cell.level, "way": cell.way}
        paths = [runs[cell, seed] for seed in seeds]
        results = [read_evaluations(path)["results"] for path in paths]
        for at in zip(*results, strict=False):
            if all(one["relief"] for one in at):
                steps = int(np.mean([one["steps"] for one in at]))
                found = over_trainings([one["relief"]["value"] for one in at])
                curves.append({**names, "steps": steps, **found})
        scores = [_read(path / SCORE, Score) for path in paths]
        reliefs = [_relief(beside[cell[:2]].tested, one) for one in scores]
        reached = [one for one in reliefs if one is not None]
        found = over_trainings(reached) if reached == reliefs else {"value": None}
        success = float(np.mean([one.success for one in scores]))
        ends.append({**names, **found, "success": success, "trainings": len(scores)})
    for (task, level), found in beside.items():
        for name in BESIDE:
            tested = found.tested[name]
            more = {"policy": name, "value": _relief(found.tested, tested)}
            more |= {"in_training": _relief(found.in_training, found.in_training[name])}
            others.append({"task": task, "level": level, **more, "success": tested.success})
    return {"curves": curves, "ends": ends, "beside": others}


def _relief(beside: Mapping[str, Score], score: Score) -> float | None:
    """Returns the mean relief of a score beside those of references in the same motions.

    It is None where an arm was lost.
    """
    if score.effort is None:
        return None
    unsuited, suited = (beside[one].effort for one in REFERENCES)
    found = None
    if unsuited is not None and suited is not None:
        found = relief(unsuited, suited, score.effort)
    if found is None:
        raise InputError("the suit costs nothing in one of the tasks: choose others")
    return float(np.mean(found))


def _table(result: Mapping[str, Any]) -> tuple[list[str], Iterator[list[str]]]:
    header = ["task", "level", "way or policy", "trainings", "relief", "success"]

    def rows() -> Iterator[list[str]]:
        for one in (*result["ends"], *result["beside"]):
            yield [
                *(one["task"], one["level"], one.get("way") or one["policy"]),
                str(one.get("trainings", "-")),
                relief_text(None if one["value"] is None else one),
                f"{one['success']:.0%}",
            ]

    return header, rows()
