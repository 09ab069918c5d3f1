"""`activesuit simulate`: one motion under one policy, as a time series."""

from pathlib import Path

from ..assets import JOINTS
from ..envs.composition import ASSISTED
from ..envs.evaluation import Trace, make_env, run_episode, score
from ..envs.figures import motion_loops_figure, torques_figure, trajectory_figure
from ..envs.policies import make_policy
from ..errors import at_least
from .output import RunFolder, table, to_json
from .tables import score_table


def simulate(
    env: str = "ActiveSuit/ArmTracking-v0",
    policy: str = "feedforward",
    suit: str = "mock-suit",
    gravity: str = "earth",
    seed: int = 0,
    out: Path = Path("runs/simulate"),
    allow_uncertified: bool = False,
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
        allow_uncertified: accept a suit whose torque could become infinite in some motion.
        json: print the result as JSON.
    """
    at_least("seed", seed, 0)
    made, arm = make_env(env, suit=suit, gravity=gravity, allow_uncertified=allow_uncertified)
    actor = make_policy(policy, arm)
    folder = RunFolder(out)
    trace = run_episode(made, actor, seed)
    made.close()
    result = score(policy, [trace])
    write_trace(folder, "trace.csv", trace)
    folder.json(
        "result.json",
        {"env": env, "suit": suit, "gravity": gravity, "seed": seed, **result.to_dict()},
    )
    traces = {policy: trace}
    folder.figure("trajectory", trajectory_figure(traces))
    folder.figure("torques", torques_figure(traces))
    folder.figure("motion-loops", motion_loops_figure(traces))
    if json:
        print(to_json(result.to_dict()))
        return
    table(f"Human torque: {env}, {gravity}, {suit}, seed {seed}", *score_table([result]))
    print(f"wrote {folder.path}/trace.csv, result.json and three figures")


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
