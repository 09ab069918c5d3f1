"""`activesuit evaluate faults`: what policies do when a sensor or a motor fails."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...checks import at_least, check_seed
from ...envs.evaluation import FIRST_SEED
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.evaluation.surprises import Surprise, surprises
from ...errors import InputError
from ..arm_options import USUAL, ArmOptions
from ..conclusion import conclude
from ..options import (
    Env,
    Force,
    Gravity,
    Json,
    Level,
    PolicyName,
    Suit,
    TaskName,
    Trust,
)
from ..output import Rows, RunFolder, markdown_table
from ..reports.why import why_remarks
from ..runs import scene

SINCE = 3.0  # s
FAULTS = {
    "none": {},
    "pads: +5 N·m": {"torque_bias": 5.0},
    "pads: drift of 0.5 N·m/s": {"torque_drift": 0.5},
    "10 % of readings late": {"late": 0.1},
    "10 % of readings lost": {"lost": 0.1},
    "elbow's encoder stuck": {"stuck": ("elbow_flexion",), "since": SINCE},
    "elbow's motor stops": {"stopped": ("elbow_flexion",), "since": SINCE},
    "both motors stop": {"stopped": ("shoulder_flexion", "elbow_flexion"), "since": SINCE},
}
ON_CUFFS = {
    "cuffs: +20 N": {"force_bias": 20.0},
    "cuffs: drift of 2 N/s": {"force_drift": 2.0},
}


def faults(
    env: Env = None,
    task: TaskName = None,
    level: Level = None,
    policies: tuple[PolicyName, ...] = ("compensation", "adaptive", "observer", "impedance"),
    suit: Suit = None,
    gravity: Gravity = None,
    episodes: int = 20,
    seed: int = FIRST_SEED,
    out: Path | None = None,
    force: Force = False,
    trust: Trust = False,
    arm: ArmOptions = USUAL,
    json: Json = False,
) -> None:
    """Measure what policies do when a sensor or a motor fails.

    The wearers have learned the motions under a policy whose sensors and motors work. Then
    something fails, from the beginning, or after 3 s for encoders and motors.

    Args:
        policies: Names of policies.
        episodes: Number of motions of each policy and fault, at least 8.
        seed: Seed of the first motion.
        out: Folder for result.json and faults.md: a new or an empty one, or that of an earlier
            run of this command.
    """
    at_least("episodes", episodes, FEWEST_MOTIONS)
    check_seed(seed)
    chosen = scene(
        arm,
        env=env,
        task=task,
        level=level,
        suit=suit,
        gravity=gravity,
        policies=policies,
        trusted=trust,
    )
    if "faults" in chosen.options:
        raise InputError("--set gives faults, and this command has its own: leave it out")
    folder = RunFolder(out, "faults", force=force) if out else None
    tried = {**FAULTS, **(ON_CUFFS if chosen.options.get("coupling") == "cuffs" else {})}
    found = surprises(
        chosen.env,
        chosen.policies,
        tried,
        episodes=episodes,
        seed=seed,
        threads=0,
        **chosen.options,
    )
    tables = {f"{chosen.place}, {episodes} motions": fault_table(found)}
    if folder:
        folder.text("faults.md", "".join(markdown_table(*one) + "\n" for one in tables.values()))
    result = {"env": chosen.env, **chosen.options, "episodes": episodes, "seed": seed}
    result["surprises"] = [one.to_dict() for one in found]
    remarks = [f"{one.fault}: {sentence}" for one in found for sentence in why_remarks([one.score])]
    conclude(result, tables, remarks, folder=folder, json=json)


def fault_table(found: Sequence[Surprise]) -> Rows:
    """Returns a row per policy and fault: success, relief, and what the fault changes."""
    header = ["policy", "fault", "success", "relief", "moves the arm\n[mrad]"]
    header += ["loads the wearer\n[N·m]"]
    rows = []
    for one in found:
        lost = f", {one.score.failures} arms lost" if one.score.failures else ""
        rows.append(
            [
                one.policy,
                one.fault,
                f"{np.mean(one.score.success):.0%}{lost}",
                "-" if one.relief is None else f"{one.relief.value:.2f}",
                f"{1e3 * np.mean(one.moved):.0f}",
                f"{np.mean(one.loaded):.1f}",
            ]
        )
    return header, rows
