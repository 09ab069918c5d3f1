"""Success, accuracy and speed of each method that fits the shipped curves from random starts."""

import statistics
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..assets import CURVES, curves_path
from ..identification import load_curves
from ..identification.study.summary import Summary, summarize
from ..identification.study.trial import StudyConfig, run_trial
from ..scripts.backends import run_all
from ..scripts.output import Rows, progress
from .timing import seconds

STARTS, STARTS_PER_REPEAT = 200, 25  # most starts; a hurried benchmark has fewer
STARTED_METHODS = ("certified", "sa-pso", "mpso")
# Of a certified fit: model runs and milliseconds at most, share of successful starts at least.
RUNS_LIMIT, TIME_LIMIT, SUCCESS_LIMIT = 200, 50.0, 0.95


@dataclass(frozen=True, kw_only=True)
class Starts:
    """Results of all starts of one method on one joint.

    Attributes:
        joint: Name of the joint.
        method: Name of the method.
        starts: Number of random starts.
        success_rate: Share of the starts that ended within 5 % of the noise floor.
        over_floor: Median NRMSE, divided by the noise floor.
        evaluations: Median number of model runs on all curves.
        most_evaluations: Largest number of model runs on all curves.
        to_target: Median number of model runs until a start was within 5 % of the noise floor;
            infinite if most starts never were.
        milliseconds: Median time of one start, alone on the machine.
        met: Whether the limits are met; None for a method that has none.
    """

    joint: str
    method: str
    starts: int
    success_rate: float
    over_floor: float
    evaluations: float
    most_evaluations: int
    to_target: float
    milliseconds: float
    met: bool | None

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


def random_starts(repeats: int) -> list[Starts]:
    """Runs every method from random starts, in parallel; `repeats` of them are timed, one by one.

    There are 25 starts per repeat, and 200 at most. The swarms get the paper's budget of 50 x 101
    model runs.
    """
    families = {name: load_curves(curves_path(name)) for name in CURVES}
    config = StudyConfig(
        methods=STARTED_METHODS,
        joints=dict.fromkeys(families, ""),
        trials=min(STARTS, STARTS_PER_REPEAT * repeats),
    )
    trials = []
    with progress("random starts", len(config.keys)) as bar:
        calls = [(config, key, families[key.joint]) for key in config.keys]
        for trial in run_all(run_trial, calls, "loky", -1):
            trials.append(trial)
            bar.advance()
    found = []
    for summary in summarize(config, families, trials):
        keys = [trial.key for trial in summary.trials[:repeats]]
        work = [lambda key=key: run_trial(config, key, families[key.joint]) for key in keys]
        work[0]()
        found.append(_starts(summary, 1e3 * statistics.median(map(seconds, work))))
    return found


def starts_table(found: list[Starts]) -> Rows:
    """Returns one row per joint and method."""
    header = ["joint", "method", "starts", "success", "NRMSE /\nfloor", "model\nruns"]
    header += ["runs to\nfloor", "ms per\nstart", "limits"]
    rows = [
        [
            one.joint,
            one.method,
            str(one.starts),
            f"{one.success_rate:.1%}",
            f"{one.over_floor:.3g}",
            f"{one.evaluations:,.0f}",
            f"{one.to_target:,.0f}" if np.isfinite(one.to_target) else "-",
            f"{one.milliseconds:.3g}",
            "-" if one.met is None else "met" if one.met else "NOT met",
        ]
        for one in found
    ]
    return header, rows


def _starts(summary: Summary, milliseconds: float) -> Starts:
    evaluations = [trial.evaluations for trial in summary.trials]
    met = (
        max(evaluations) <= RUNS_LIMIT
        and milliseconds <= TIME_LIMIT
        and summary.success_rate >= SUCCESS_LIMIT
    )
    return Starts(
        joint=summary.joint,
        method=summary.method,
        starts=len(summary.trials),
        success_rate=summary.success_rate,
        over_floor=float(summary.nrmse[1] / summary.noise),
        evaluations=float(np.median(evaluations)),
        most_evaluations=max(evaluations),
        to_target=float(summary.to_target[1]),
        milliseconds=milliseconds,
        met=met if summary.method == "certified" else None,
    )
