"""`activesuit evaluate branch`: the next second of one motion under each of some policies."""

from pathlib import Path

from ...checks import check_seed
from ...envs.evaluation.branching import Fork
from ...envs.evaluation.branching import branch as branches_of
from ...envs.figures import branches_figure
from ...envs.model import ASSISTED
from ..arm_options import USUAL, ArmOptions
from ..conclusion import conclude
from ..options import (
    Env,
    EvaluatedName,
    Force,
    Gravity,
    Json,
    Level,
    PolicyName,
    Seed,
    Suit,
    TaskName,
    Trust,
)
from ..output import Rows, RunFolder
from ..runs import scene


def branch(
    env: Env = None,
    task: TaskName = None,
    level: Level = None,
    base: PolicyName = "feedforward",
    policies: tuple[EvaluatedName, ...] = ("none", "transparent", "feedforward", "compensation"),
    at: tuple[float, ...] = (2.0,),
    horizon: float = 1.0,
    suit: Suit = None,
    gravity: Gravity = None,
    seed: Seed = 0,
    out: Path | None = None,
    force: Force = False,
    trust: Trust = False,
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Show the next second of a motion under each of some policies.

    A base policy moves the arm up to a branch point. From the state there, which all branches share
    to the last bit, the motion goes on under each policy, which has watched what came before, and
    under the best known plan. Regret is the effort less that under this plan. The wearer has
    learned nothing of suit and exoskeleton yet.

    Args:
        base: Policy up to the branch point.
        policies: Names of policies and bounds from there on.
        at: Times of the branch points [s].
        horizon: Duration of a branch [s].
        out: Folder for result.json and a figure for each branch point: a new or an empty one, or
            that of an earlier branch.
    """
    check_seed(seed)
    chosen = scene(
        arm,
        env=env,
        task=task,
        level=level,
        suit=suit,
        gravity=gravity,
        policies=(base, *policies),
        trusted=trust,
    )
    before, *after = chosen.policies
    options = {"at": at, "horizon": horizon, "seed": seed}
    forks = branches_of(chosen.env, after, base=before, **options, **chosen.options)
    folder = RunFolder(out, "branch", force=force) if out else None
    if folder:
        for fork in forks:
            folder.figure(f"branches-{fork.at:g}s", branches_figure(fork))
    result = {"env": chosen.env, **chosen.options, "base": base, **options}
    result["forks"] = [fork.to_dict() for fork in forks]
    tables = {
        f"{chosen.place}, after {fork.at:g} s of {base}, for {horizon:g} s": fork_table(fork)
        for fork in forks
    }
    conclude(result, tables, folder=folder, json=json)


def fork_table(fork: Fork) -> Rows:
    """Returns one row per policy: effort, regret, torque of shoulder and elbow, and tracking."""
    header = ["policy", "effort\n[%]", "regret\n[%]", "human\n[N·m]", "suit\n[N·m]"]
    header += ["assist\n[N·m]", "error\n[mrad]"]
    rows = []
    for name, future in fork.futures.items():
        found = future.to_dict()
        torques = (
            "/".join(f"{found[of][joint]:.2f}" for joint in ASSISTED)
            for of in ("human_torque_nm", "suit_torque_nm", "assist_torque_nm")
        )
        title = f"{name} (lost the arm)" if future.lost else name
        effort, regret = 100 * future.mean_effort, 100 * fork.regret(name)
        error = f"{1e3 * future.tracking:.0f}"
        rows.append([title, f"{effort:.1f}", f"{regret:.1f}", *torques, error])
    return header, rows
