"""What tuning optimizes: effort in motions that the benchmark never shows."""

import numpy as np

from ...errors import InputError
from ..evaluation.core import run
from ..evaluation.wearers import ArmLost
from ..policies import PolicySpec
from ..policies.build import believes, maker_of
from .suite import Setting

TASKS = ("ArmTracking", "Ratchet")
BELIEVED = "emu-like"
MOTIONS = 6
FIRST_SEED = 0  # far from those of evaluations, which begin at 10,000
WORST = 10.0  # times strength, where a policy loses the arm


def tunable(name: str) -> dict[str, tuple[float, float]]:
    """Returns the options of a policy that are tuned, each with its least and greatest value.

    Raises:
        InputError: There is no such policy, or nothing to tune in it.
    """
    found = getattr(maker_of(name), "tunable", {})
    if not found:
        raise InputError(f"policy {name!r} has no option to tune: choose another policy")
    return dict(found)


def tuning_cost(spec: PolicySpec) -> float:
    """Returns the mean effort of adapted wearers at the level "randomized", over strength.

    Args:
        spec: Policy with its options.

    Raises:
        InputError: See `make_policy`.
    """
    if believes(spec.name):
        spec = PolicySpec(spec.name, {"suit": BELIEVED, **spec.options})
    found = []
    for task in TASKS:
        setting = Setting(task, "randomized", BELIEVED)
        seeds = range(FIRST_SEED, FIRST_SEED + MOTIONS)
        env, options = f"ActiveSuit/{task}-v0", {**setting.options, "threads": 1}
        try:
            score = run(spec.name, spec, env, seeds, **options).score
            found.append(WORST if score.failures else float(np.mean(score.effort)))
        except ArmLost:
            found.append(WORST)
    return float(np.mean(found))
