"""What do ways of training reach, over tasks, levels and seeds?

A network gives the motors' torques alone (`ppo`), or corrects compensation that believes the suit
mock-suit (`residual`), a belief that is wrong at level shift. Beside them are policies that do not
learn, on the same motions.

Each training is a run of `activesuit train`. Ten times its policy is scored by the relief of
adapted wearers in eight motions (the curves of the figure), and the best policy is kept. The table
has the relief of the kept policies in 20 other motions: the interquartile mean over trainings, with
its 95 % interval from five trainings on. `results.jsonl` has a line for each training and for each
policy beside, with the values of every motion, from which all reliefs are computed.
What trains at level randomized is tested at level unseen.

A correction begins with what compensation knows, and so needs few steps. A network alone needs more
steps than this small part of the study has. The whole study takes many hours; trainings and
`results.jsonl` stay in the folder `--out`, and the same command goes on there.

    T="--tasks ArmTracking RangeOfMotion ObjectRelocation --levels nominal randomized shift"
    python examples/learning.py $T --seeds 0-9 --steps 200000 --ways ppo ppo-history residual
"""

import json
import subprocess
import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import tyro
from activesuit.envs.evaluation import FIRST_SEED, REFERENCES, Score
from activesuit.envs.evaluation.relief import relief
from activesuit.envs.evaluation.run import run
from activesuit.envs.evaluation.wearers import ArmLost
from activesuit.envs.policies import policy_spec
from activesuit.errors import unknown_name
from activesuit.scripts.training.evaluations import FIRST, MOTIONS, read_evaluations, relief_text
from activesuit.scripts.training.seeds import over_trainings, seeds_of
from matplotlib.figure import Figure

COMPENSATION = "--residual compensation:suit=mock-suit"
WAYS = {  # options of `activesuit train`
    "ppo": "",
    "sac": "--algo sac",
    "tqc": "--algo tqc",
    "recurrent-ppo": "--algo recurrent-ppo",
    "ppo-history": "--history 5",
    "residual": COMPENSATION,
    "residual-history": f"{COMPENSATION} --history 5",
    "residual-guided": f"{COMPENSATION} --control.stiff",  # wearers led by stiff hands
    "residual-drawn": f"{COMPENSATION} --history 5 --level randomized "
    "--randomize.suits mock-suit emu-like",
    "student": "--teacher adaptive:suit=mock-suit --history 10",
}
BESIDE = {  # policies that do not learn, with color and line
    "compensation:suit=mock-suit": ("0.45", "--"),
    "adaptive:suit=mock-suit": ("0.2", "-."),
    "best-known-plan": ("0.2", ":"),
}
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c564b")
TESTED_AT = {"randomized": "unseen"}  # levels of tests, where they are not those of the training
TESTED = range(FIRST_SEED, FIRST_SEED + 20)
IN_TRAINING = range(FIRST, FIRST + MOTIONS)
EMPTY: tuple[list, ...] = ([], [], [], [], [])  # the series of a row before a test


class Row(NamedTuple):
    """A line of results.jsonl: a training, or a policy beside with neither steps nor seed.

    Attributes:
        motion: Seeds of the tested motions.
        effort: Effort in each of these motions; empty where an arm was lost.
        success: Whether each of these motions succeeded.
        chatter: Sum of the squared changes of the action in each of these motions.
        in_training: Effort in each motion of the curves, of policies beside.
    """

    task: str
    level: str
    way: str
    steps: int
    seed: int
    motion: list[int]
    effort: list[float]
    success: list[bool]
    chatter: list[float]
    in_training: list[float]


class Study:
    """Trainings and their results in a folder.

    Attributes:
        folder: The folder.
        rows: Results so far, by task, level, way, steps and seed.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.rows: dict[tuple[object, ...], Row] = {}
        folder.mkdir(parents=True, exist_ok=True)
        self._table = folder / "results.jsonl"
        if self._table.exists():
            for line in self._table.read_text(encoding="utf-8").splitlines():
                self._keep(Row(**json.loads(line)))

    def _keep(self, row: Row) -> None:
        self.rows[row[:5]] = row

    def add(self, row: Row) -> None:
        """Adds a result, to the file as well."""
        self._keep(row)
        with self._table.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row._asdict()) + "\n")

    def relief(self, row: Row, *, in_training: bool = False) -> float:
        """Returns the mean relief of a result; NaN for a lost arm, or a suit that costs little."""
        beside = [self.rows[row.task, row.level, name, 0, 0] for name in REFERENCES]
        series = [x.in_training if in_training else x.effort for x in (*beside, row)]
        found = relief(*series) if series[-1] else None
        return np.nan if found is None else float(np.mean(found))

    def path(self, task: str, level: str, way: str, steps: int) -> Path:
        """Returns the folder of the trainings of a way, one subfolder a seed."""
        return self.folder / f"{task}-{level}-{way}-{steps}"

    def train(
        self, task: str, level: str, way: str, steps: int, seeds: list[int], workers: int
    ) -> None:
        """Trains and tests a way with the seeds that have no result yet."""
        left = [one for one in seeds if (task, level, way, steps, one) not in self.rows]
        if not left:
            return
        out = self.path(task, level, way, steps)
        options = ["--task", task, "--steps", steps, "--out", out, *WAYS[way].split()]
        options += [] if "--level" in WAYS[way] else ["--level", level]
        options += ["--seeds", ",".join(map(str, left)), "--workers", workers, "--resume"]
        program = [sys.executable, "-m", "activesuit.scripts.main", "train"]
        subprocess.run([*program, *map(str, options)], check=True, stdout=subprocess.DEVNULL)
        for seed in left:
            self.add(tested(Row(task, level, way, steps, seed, *EMPTY), f"{out / f'seed-{seed}'}"))

    def compare(self, task: str, level: str, policies: Sequence[str]) -> None:
        """Tests references, and policies that do not learn."""
        for name in (*REFERENCES, *policies):
            if (task, level, name, 0, 0) not in self.rows:
                row = tested(Row(task, level, name, 0, 0, *EMPTY), name)
                before = scored(name, task, level, IN_TRAINING)
                self.add(row._replace(in_training=[*before.effort] if before else []))


def scored(name: str, task: str, level: str, seeds: range) -> Score | None:
    """Returns the score of a policy; None where it loses an arm."""
    given = name if name in (*REFERENCES, "best-known-plan") else policy_spec(name)
    try:
        return run(name, given, f"ActiveSuit/{task}-v0", seeds, level=level).score
    except ArmLost:
        return None


def tested(row: Row, name: str) -> Row:
    """Returns a row with the values of a policy in the tested motions."""
    one = scored(name, row.task, TESTED_AT.get(row.level, row.level), TESTED)
    row = row._replace(motion=[*TESTED], success=[False] * len(TESTED))
    if one is None:
        return row
    values = {"effort": one.effort, "success": one.success, "chatter": one.costs["chatter"]}
    return row._replace(**{series: [*found] for series, found in values.items()})


def curve(folder: Path, seeds: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Returns steps and the relief of each training at them, shape (seeds, evaluations)."""
    results = [read_evaluations(folder / f"seed-{seed}")["results"] for seed in seeds]
    shortest = min(map(len, results))  # a training that lost patience has fewer
    values = [
        [one["relief"]["value"] if one["relief"] else np.nan for one in found[:shortest]]
        for found in results
    ]
    return np.array([one["steps"] for one in results[0][:shortest]]), np.array(values)


def draw(
    study: Study,
    tasks: Sequence[str],
    levels: Sequence[str],
    ways: Sequence[str],
    steps: int,
    seeds: list[int],
) -> Figure:
    """Draws relief over the steps of the trainings, a panel for each task and level."""
    size = 3.4 * len(levels) + 1.4, 2.8 * len(tasks) + 1
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(len(tasks), len(levels), squeeze=False, sharex=True)
    for ax, (task, level) in zip(axes.flat, product(tasks, levels), strict=True):
        for color, way in zip(COLORS * 2, ways, strict=False):
            at, values = curve(study.path(task, level, way, steps), seeds)
            ax.plot(at, values.T, color=color, lw=0.6, alpha=0.5)
            ax.plot(at, np.mean(values, axis=0), color=color, lw=1.8, label=way)
        for name, (color, style) in BESIDE.items():
            if (beside := study.rows.get((task, level, name, 0, 0))) is not None:
                label = name.partition(":")[0]
                level_of = study.relief(beside, in_training=True)
                ax.axhline(level_of, color=color, ls=style, lw=1, label=label)
        ax.set_title(f"{task}, {level}")
        ax.grid(alpha=0.25)
    for ax in axes[-1]:
        ax.set_xlabel("steps of the training")
    for ax in axes[:, 0]:
        ax.set_ylabel("relief of adapted wearers")
    lines, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(lines, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def main(
    ways: tuple[str, ...] = ("ppo", "residual"),
    tasks: tuple[str, ...] = ("ArmTracking",),
    levels: tuple[str, ...] = ("nominal", "shift"),
    seeds: str = "0-1",
    steps: int = 40_000,
    workers: int = 1,
    out: Path = Path("runs/learning"),
    quick: bool = False,
) -> None:
    """Compare ways of training over tasks, levels and seeds.

    Args:
        ways: Names of ways of training, of those in WAYS.
        tasks: Names of tasks.
        levels: Names of levels.
        seeds: Seeds of the trainings, as 0-9 or 0,3,5.
        steps: Number of environment steps of each training.
        workers: Number of trainings at once.
        out: Folder of the trainings and of results.jsonl; what is there is not done again.
        quick: Train one correction at one level for a few steps, beside compensation alone.
    """
    if quick:
        ways, levels, seeds, steps = ("residual",), levels[:1], "0", 4096
    beside = tuple(BESIDE)[: 1 if quick else None]
    for way in ways:
        if way not in WAYS:
            raise unknown_name("way of training", way, WAYS)
    chosen, study = seeds_of(seeds), Study(out)
    print(
        f"{'task':17}{'level':12}{'way or policy':29}{'trainings':>9}  {'relief':20}{'success':>8}"
    )
    for task, level in product(tasks, levels):
        study.compare(task, level, beside)
        for way in ways:
            study.train(task, level, way, steps, chosen, workers)
            rows = [study.rows[task, level, way, steps, seed] for seed in chosen]
            show(study, rows, len(rows))
        for name in beside:
            show(study, [study.rows[task, level, name, 0, 0]], 0)
    draw(study, tasks, levels, ways, steps, chosen).savefig("learning.png", dpi=150)


def show(study: Study, rows: Sequence[Row], trainings: int) -> None:
    """Prints a line of the table: a way over its trainings, or a policy beside (0 trainings)."""
    reliefs = [study.relief(one) for one in rows]
    text = relief_text(over_trainings(reliefs)) if np.isfinite(reliefs).all() else "-"
    success = np.mean([one.success for one in rows])
    first = rows[0]
    line = f"{first.task:17}{first.level:12}{first.way:29}{trainings or '-':>9}  {text:20}"
    print(f"{line}{success:8.1%}", flush=True)


if __name__ == "__main__":
    tyro.cli(main)
