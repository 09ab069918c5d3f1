"""Does the verdict on SA-PSO hang on Vmax, which Li et al. (2022) do not print?

    python -m activesuit.reproductions.li_2022_velocity --trials 30

`li_2022` assumes a fifth of each range. Trials of another Vmax have the same seeds as its own.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..files import write_text
from .li_2022 import FITNESS, JOINTS, runs_of, spread
from .results import Results, run
from .verdicts import RULE, judged

LIMITS = (0.02, 0.05, 0.2, 1.0)  # Vmax over the range of each parameter
KEPT = "li-2022-velocity.json"  # fitness of all trials
COMMAND = "python -m activesuit.reproductions.li_2022_velocity"
HEADER = (
    "joint | Vmax / range | trials of each | SA-PSO: quartiles of fitness | MPSO: quartiles | "
    "medians, SA-PSO / MPSO | advantage of SA-PSO | verdict"
)


def rows(found: Sequence[dict[str, Any]], seed: int) -> list[list[str]]:
    """Returns the rows of the table.

    Args:
        found: The joint, the Vmax over the range, and the fitness of all trials by method, each.
        seed: Seed of the bootstrap.
    """
    cells = []
    for one in found:
        ours, other = (np.array(one["fitness"][method]) for method in ("sa-pso", "mpso"))
        sa_pso, mpso = FITNESS[one["joint"]]
        quartiles = (spread(values, ".3g")[1] for values in (ours, other))
        verdict = judged(ours, other, mpso / sa_pso - 1, seed=seed)
        shown = [one["joint"], f"{one['limit']:g}", f"{ours.size}"]
        cells.append([*shown, *quartiles, *verdict.cells])
    return cells


def main(
    trials: int = 30,
    seed: int = 0,
    iterations: int = 100,
    out: Path = Path("runs/li_2022_velocity"),
    page: Path | None = None,
) -> None:
    """Compare SA-PSO with MPSO as Li et al. (2022) do, at four values of Vmax.

    Args:
        trials: Number of runs of each method on each joint and at each Vmax; the paper has 30.
        seed: Seed of all random numbers.
        iterations: Number of moves of a swarm; the paper has 100.
        out: Folder for tables.md and the fitness of all trials.
        page: Page of the documentation that gets the table between its marks; the folder `measured`
            beside it gets the fitness of all trials.
    """
    sizes = {"trials": trials, "seed": seed, "iterations": iterations}
    found = []
    for joint in JOINTS:
        for limit in LIMITS:
            fitness = {
                method: runs_of(joint, method, velocity_limit=limit, **sizes).fitness.tolist()
                for method in ("sa-pso", "mpso")
            }
            found.append({"joint": joint, "limit": limit, "fitness": fitness})
    results = Results(out)
    results.table("Vmax: best fitness", RULE, HEADER, rows(found, seed), on_page=True)
    results.finish(page)
    content = {"command": COMMAND, "version": __version__, "result": found}
    for folder in (out, *([page.parent / "measured"] if page else [])):
        folder.mkdir(exist_ok=True)
        write_text(folder / KEPT, f"{json.dumps(content, indent=1)}\n")


if __name__ == "__main__":
    run(main)
