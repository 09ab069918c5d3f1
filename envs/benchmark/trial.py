"""One trial of the benchmark: a policy, on all motions of a setting, with adapted wearers.

A worker runs it on one thread, so that trials may run beside each other.
"""

import math
from collections.abc import Sequence
from importlib.metadata import version
from typing import Any, NamedTuple

from ...errors import InputError
from ..evaluation import BOUNDS, FIRST_SEED, REFERENCES
from ..evaluation.core import run
from ..evaluation.reasons import Frequent, most_frequent
from ..evaluation.rollout import Trace
from ..extras import SCORES, Score
from .results import Result
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
        InputError: The suite has the score of an extra that is missing.
    """
    episodes = suite.motions_of(trial.policy)
    failed, extra = None, {}
    try:
        found, traces = _run(suite, trial, episodes)
    except InputError as error:
        nothing = (math.inf,) * episodes
        found = _Found(nothing, nothing, nothing, (False,) * episodes)
        failed = str(error)
    else:
        extra = {name: _scored(SCORES.find(name), traces) for name in suite.scores}
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
        extra=extra,
    )


class _Found(NamedTuple):
    effort: tuple[float, ...]
    assisted_effort: tuple[float, ...]
    tracking: tuple[float, ...]
    success: tuple[bool, ...]
    why: tuple[Frequent, ...] = ()


def _run(suite: Suite, trial: Trial, episodes: int) -> tuple[_Found, list[Trace]]:
    options = suite.environment(trial.setting)
    env, seeds = f"ActiveSuit/{trial.setting.task}-v0", range(FIRST_SEED, FIRST_SEED + episodes)
    name = trial.policy.name
    given = name if name in (*REFERENCES, *BOUNDS) else trial.policy
    found, traces, _ = run(trial.label, given, env, seeds, threads=1, **options)
    scored = _Found(
        _rounded(found.effort),
        _rounded(found.assisted_effort),
        _rounded(found.tracking),
        found.success,
        most_frequent(found.why),
    )
    return scored, traces


def _scored(score: Score, traces: Sequence[Trace]) -> dict[str, Any]:
    """Returns what a score keeps of the motions, or why they cannot be scored."""
    try:
        found = score.scored(traces, threads=1, on_motion=lambda: None)
    except InputError as error:
        return {"reason": str(error)}
    packages = {name: version(name) for name in score.packages}
    return {"costs": _plain(found.costs), "facts": _plain(found.facts), "packages": packages}


def _plain(value: Any) -> Any:
    """Returns a value of a score as JSON has it: rounded, and None where it is not finite."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    return _rounded([value])[0] if math.isfinite(value) else None


def _rounded(values: Sequence[float]) -> tuple[float, ...]:
    """Returns values as they are kept; infinite ones in place of NaN."""
    return tuple(
        math.inf if math.isnan(value) else float(f"{round(value, SMALLEST):.{DIGITS}g}")
        for value in values
    )
