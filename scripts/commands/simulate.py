"""`activesuit simulate`: one motion under one policy, as a time series."""

from pathlib import Path

from ...assets import JOINTS
from ...checks import at_least
from ...envs.evaluation import Trace, make_env, run_episode, score
from ...envs.figures import (
    cuff_forces_figure,
    motion_loops_figure,
    torques_figure,
    trajectory_figure,
)
from ...envs.model import ASSISTED
from ...envs.policies import make_policy
from ..options import USUAL, ArmOptions
from ..output import RunFolder, table, to_json
from ..reports.tables import cuff_remarks, effort_table, score_table


def simulate(
    env: str = "ActiveSuit/ArmTracking-v0",
    policy: str = "feedforward",
    suit: str = "mock-suit",
    gravity: str = "earth",
    seed: int = 0,
    out: Path = Path("runs/simulate"),
    arm: ArmOptions = USUAL,
    json: bool = False,
) -> None:
    """Simulate one assisted arm motion, headless.

    Args:
        env: ActiveSuit/ShoulderFlexion-v0, ElbowFlexion-v0 or ArmTracking-v0.
        policy: none, gravity, feedforward, oracle, or the folder of a training run.
        suit: name of a shipped suit, or a suit file.
        gravity: earth, mars, moon or microgravity.
        seed: fixes the motion.
        out: folder for trace.csv, result.json and figures.
        arm: wearer, coupling and load.
        json: print the result as JSON.
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


def write_trace(folder: RunFolder, name: str, trace: Trace) -> None:
    """Writes a trace as CSV: time [s], angles [rad] and torques [N·m] by joint."""
    header = ["time_s"]
    columns = [trace.time[:, None]]
    for label, joints, values in (
        ("angle_rad", JOINTS, trace.angle),
        ("target_angle_rad", JOINTS, trace.target_angle),
        ("human_torque_nm", JOINTS, trace.human_torque),
        ("suit_torque_nm", JOINTS, trace.suit_torque),
        ("assist_torque_nm", ASSISTED, trace.assist_torque),
    ):
        header += [f"{joint}_{label}" for joint in joints]
        columns.append(values)
    rows = zip(*(column for block in columns for column in block.T), strict=True)
    folder.csv(name, header, ([f"{value:.6g}" for value in row] for row in rows))
