"""`activesuit simulate`: simulates one motion under one policy, and writes its time series."""

from pathlib import Path

from ...checks import at_least
from ...envs.evaluation import make_env, run_episode, score
from ...envs.figures import (
    cuff_forces_figure,
    motion_loops_figure,
    torques_figure,
    trajectory_figure,
)
from ...envs.policies import make_policy
from ..arm_options import USUAL, ArmOptions
from ..options import Env, Gravity, Json, PolicyName, Seed, SuitName
from ..output import RunFolder, table, to_json
from ..reports.motions import cuff_remarks, effort_table, score_table, write_trace


def simulate(
    env: Env = "ActiveSuit/ArmTracking-v0",
    policy: PolicyName = "feedforward",
    suit: SuitName = "mock-suit",
    gravity: Gravity = "earth",
    seed: Seed = 0,
    out: Path = Path("runs/simulate"),
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Simulate one assisted arm motion, headless.

    Args:
        out: Folder for trace.csv, result.json and the figures.
    """
    at_least("seed", seed, 0)
    options = arm.config(suit, gravity)
    made, simulated = make_env(env, **options)
    actor = make_policy(policy, simulated)
    folder = RunFolder(out)
    trace = run_episode(made, actor, seed)
    made.close()
    result = score(policy, [trace])
    write_trace(folder, "trace.csv", trace)
    folder.json("result.json", {"env": env, "seed": seed, **options, **result.to_dict()})
    figures = {
        "trajectory": trajectory_figure,
        "torques": torques_figure,
        "motion-loops": motion_loops_figure,
    }
    if trace.cuff_force is not None:
        figures["cuff-forces"] = cuff_forces_figure
    for name, draw in figures.items():
        folder.figure(name, draw({policy: trace}))
    if json:
        print(to_json(result.to_dict()))
        return
    table(f"Human torque: {env}, {gravity}, {suit}, seed {seed}", *score_table([result]))
    table("Effort", *effort_table([result]))
    for remark in cuff_remarks([result]):
        print(remark)
    print(f"wrote {folder.path}/trace.csv, result.json and {len(figures)} figures")
