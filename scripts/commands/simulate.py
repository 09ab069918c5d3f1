"""`activesuit simulate`: simulates one motion under one policy, and writes its time series."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from ...checks import check_seed
from ...envs.evaluation import Trace, rollout, score
from ...envs.figures import (
    cuff_forces_figure,
    motion_loops_figure,
    strain_figure,
    torques_figure,
    trajectory_figure,
)
from ...envs.making import make_arms
from ...envs.policies import make_policy, needed_options
from ..html.motions import kept_motion, outcome
from ..html.writing import write_report
from ..options import Force, Json, PolicyName, Seed, Trust
from ..output import RunFolder, say, table, to_json
from ..reports.motions import cuff_remarks, effort_table, score_table, write_trace
from ..reports.why import why_remarks
from ..scene import scene


def simulate(
    policy: PolicyName = "compensation",
    seed: Seed = 0,
    out: Path = Path("runs/simulate"),
    force: Force = False,
    trust: Trust = False,
    json: Json = False,
    **options: Any,
) -> None:
    """Simulate one assisted arm motion, headless.

    The wearer has learned nothing of suit and exoskeleton yet.

    Args:
        out: Folder for trace.csv, result.json, report.html and the figures: a new or an empty one.
    """
    check_seed(seed)
    chosen = scene(options, policies=(policy,), trusted=trust)
    (acting,) = chosen.policies
    options = {**chosen.options, **needed_options(acting)}
    arms = make_arms(chosen.env, 1, **options)
    actor = make_policy(acting, arms)
    folder = RunFolder(out, force=force)
    (trace,) = rollout(arms, actor, [seed])
    arms.close()
    result = score(policy, [trace])
    settings = {"env": chosen.env, "seed": seed, **chosen.options}
    figures = _figures(trace)
    tables = {
        f"Human torque: {chosen.place}, seed {seed}": score_table([result]),
        "Effort": effort_table([result]),
    }
    write_trace(folder, "trace.csv", trace)
    folder.json("result.json", {**settings, **result.to_dict()})
    for name, draw in figures.items():
        folder.figure(name, draw({policy: trace}))
    write_report(
        *(folder, "simulate", f"{chosen.place}, seed {seed}"),
        answer=[outcome(result), *why_remarks([result]), *cuff_remarks([result])],
        tables=tables,
        settings={"policy": policy, **settings},
        motions=[kept_motion(chosen.place, policy, "trace.csv", trace)],
    )
    if json:
        print(to_json(result.to_dict()))
        return
    for title, rows in tables.items():
        table(title, *rows)
    for remark in why_remarks([result]):
        say(remark)
    for remark in cuff_remarks([result]):
        say(remark)
    say(f"wrote {folder.path}/trace.csv, result.json, report.html and {len(figures)} figures")


def _figures(trace: Trace) -> dict[str, Callable[[Mapping[str, Trace]], Figure]]:
    """Returns the functions that draw an episode, by the names of their files."""
    figures = {
        "trajectory": trajectory_figure,
        "torques": torques_figure,
        "motion-loops": motion_loops_figure,
        "strain": strain_figure,
    }
    if trace.cuff_force is not None:
        figures["cuff-forces"] = cuff_forces_figure
    return figures
