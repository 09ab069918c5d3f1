"""One trial of the benchmark: a policy, on all motions of a setting, with adapted wearers.

A worker runs it on one thread, so that trials may run beside each other.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from ...errors import InputError
from ..evaluation import BOUNDS, FIRST_SEED, REFERENCES
from ..evaluation.core import run
from ..evaluation.reasons import Frequent, most_frequent
from ..evaluation.rollout import Trace
from ..muscles import MuscleScore, MyoArm, muscle_scores
from .results import MUSCLE_SERIES, Result
from .suite import Suite, Trial

DIGITS = 6  # significant digits of efforts and errors
SMALLEST = 12  # number of decimals; smaller errors are rounding


def run_trial(suite: Suite, trial: Trial) -> Result:
    """Runs one trial.

    Args:
        suite: What the benchmark runs.
        trial: One of its trials.

    Returns:
        The result; where the policy cannot act, every motion of it is failed, and why is said.

    Raises:
        InputError: The suite has muscles, and the extra is missing.
    """
    if suite.muscles:
        MyoArm.load()
    episodes = suite.episodes_of(trial.policy)
    failed = None
    try:
        found = _run(suite, trial, episodes)
    except InputError as error:
        nothing = (math.inf,) * episodes
        found = _Found(nothing, nothing, nothing, (False,) * episodes)
        failed = str(error)
    return Result(
        task=trial.setting.task,
        level=trial.setting.level,
        believed=trial.setting.believed,
        policy=trial.label,
        options=trial.policy.to_dict(),
        failed=failed,
        protocol=suite.protocol(trial.policy),
        effort=found.effort,
        assisted_effort=found.assisted_effort,
        tracking=found.tracking,
        success=found.success,
        why=found.why,
        muscles=found.muscles,
        no_muscles=found.no_muscles,
    )


class _Found(NamedTuple):
    effort: tuple[float, ...]
    assisted_effort: tuple[float, ...]
    tracking: tuple[float, ...]
    success: tuple[bool, ...]
    why: tuple[Frequent, ...] = ()
    muscles: MuscleScore | None = None
    no_muscles: str | None = None


def _run(suite: Suite, trial: Trial, episodes: int) -> _Found:
    options = suite.environment(trial.setting)
    env, seeds = f"ActiveSuit/{trial.setting.task}-v0", range(FIRST_SEED, FIRST_SEED + episodes)
    name = trial.policy.name
    given = name if name in (*REFERENCES, *BOUNDS) else trial.policy
    found, traces, _ = run(trial.label, given, env, seeds, threads=1, **options)
    muscles, no_muscles = _muscles(traces) if suite.muscles else (None, None)
    return _Found(
        _rounded(found.effort),
        _rounded(found.assisted_effort),
        _rounded(found.tracking),
        found.success,
        most_frequent(found.why),
        muscles,
        no_muscles,
    )


def _muscles(traces: Sequence[Trace]) -> tuple[MuscleScore | None, str | None]:
    """Returns the score of the wearer's muscles, or why they cannot be scored."""
    try:
        found = muscle_scores(traces, threads=1)
    except InputError as error:
        return None, str(error)
    rounded: dict[str, Any] = {}
    for name, value in vars(found).items():
        if name in MUSCLE_SERIES:
            rounded[name] = {one: _rounded(values) for one, values in value.items()}
        elif isinstance(value, dict):
            rounded[name] = dict(zip(value, _rounded([*value.values()]), strict=True))
        else:
            (rounded[name],) = _rounded([value])
    return MuscleScore(**rounded), None


def _rounded(values: Sequence[float]) -> tuple[float, ...]:
    """Returns values as they are kept; infinite ones in place of NaN."""
    return tuple(
        math.inf if math.isnan(value) else float(f"{round(value, SMALLEST):.{DIGITS}g}")
        for value in values
    )
