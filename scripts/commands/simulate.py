"""`activesuit simulate`: simulates one motion under one policy, and writes its time series."""

from pathlib import Path
from typing import Any

from ...checks import check_seed
from ...envs.evaluation import rollout, score
from ...envs.evaluation.figures import motion_plots
from ...envs.evaluation.report import effort_table, score_table, trace_columns
from ...envs.evaluation.sentences import cuff_remarks, outcome, why_remarks
from ...envs.making import make_arms
from ...envs.policies import make_policy, needed_options
from ..folders import RunFolder
from ..options import Force, Json, PolicyName, Seed, Trust
from ..scene import scene
from ..writer import Report, conclude


def simulate(
    policy: PolicyName = "compensation",
    seed: Seed = 0,
    out: Path | None = None,
    force: Force = False,
    trust: Trust = False,
    json: Json = False,
    **options: Any,
) -> None:
    """Simulate one assisted arm motion, headless.

    The wearer has not adapted to suit and exoskeleton.

    Args:
        out: Folder for trace.csv, result.json, report.html and the figures: a new or an empty
            folder.
    """
    check_seed(seed)
    chosen = scene(options, policies=(policy,), trusted=trust)
    (acting,) = chosen.policies
    options = {**chosen.options, **needed_options(acting)}
    arms = make_arms(chosen.env, 1, **options)
    actor = make_policy(acting, arms)
    folder = RunFolder.of(out, "simulate", force=force)
    (trace,) = rollout(arms, actor, [seed])
    arms.close()
    found = score(policy, [trace])
    settings = {"env": chosen.env, "policy": policy, "seed": seed, **chosen.options}
    report = Report(
        heading="Simulated motion",
        about=f"{chosen.place}, seed {seed}",
        result={**settings, **found.to_dict()},
        tables={
            f"Scores: {chosen.place}, seed {seed}": score_table([found]),
            "Effort": effort_table([found]),
        },
        answer=[outcome(found), *why_remarks([found]), *cuff_remarks([found])],
        columns={"trace.csv": trace_columns({policy: trace})},
        plots=motion_plots({policy: trace}),
        settings=settings,
    )
    conclude(report, folder, json)
