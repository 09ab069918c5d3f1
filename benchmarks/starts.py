"""Success, accuracy and speed of each method that fits the shipped curves from random starts."""

import statistics
import zlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..assets import CURVES, curves_path
from ..identification import SWARMS, CurveObjective, Curves, certified_fit, load_curves
from ..identification.data.curves import noise_floor
from ..published import LI_BOUNDS
from ..scripts.backends import run_all
from ..scripts.output import progress
from ..tables import Rows
from .timing import seconds

STARTS, STARTS_PER_REPEAT = 200, 25  # most starts; a hurried benchmark has fewer
STARTED_METHODS = ("certified", "sa-pso", "mpso")
# Of a certified fit: model runs and milliseconds at most, share of successful starts at least.
RUNS_LIMIT, TIME_LIMIT, SUCCESS_LIMIT = 200, 50.0, 0.95
SUCCESS = 1.05  # largest ratio of a successful NRMSE to the noise floor
SWARM_SIZE, ITERATIONS = 50, 100  # of a swarm, as in Li et al. 2022


class Start(NamedTuple):
    """One start of a method."""

    key: tuple[str, str, int]  # joint, method, number
    nrmse: float
    evaluations: int  # model runs on all curves
    history: list[tuple[int, float]]  # evaluations so far, and the best NRMSE until then


def run_start(curves: Curves, joint: str, method: str, number: int) -> Start:
    """Fits curves once, from the random numbers of that start."""
    rng = np.random.default_rng([zlib.crc32(f"{joint} {method}".encode()), number])
    if method == "certified":
        fit = certified_fit(curves, rng=rng)
        return Start((joint, method, number), fit.loss, fit.evaluations or 0, list(fit.history))
    objective = CurveObjective(curves)
    found = SWARMS[method](
        objective, LI_BOUNDS, rng=rng, swarm_size=SWARM_SIZE, max_iterations=ITERATIONS
    )
    history = [(SWARM_SIZE * (i + 1), float(best)) for i, best in enumerate(found.history)]
    return Start((joint, method, number), float(found.fun), objective.evaluations, history)


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
        to_target: Median number of model runs until a start was within 5 % of the noise floor, of
            a swarm until the end of that iteration; infinite if most starts never were.
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
    families = {name: load_curves(curves_path(name)).fitted() for name in CURVES}
    numbers = range(min(STARTS, STARTS_PER_REPEAT * repeats))
    calls = [
        (curves, joint, method, number)
        for joint, curves in families.items()
        for method in STARTED_METHODS
        for number in numbers
    ]
    done = []
    with progress("random starts", len(calls)) as bar:
        for start in run_all(run_start, calls, "loky", -1):
            done.append(start)
            bar.advance()
    found = []
    for joint, curves in families.items():
        floor = noise_floor(curves) / curves.peak
        for method in STARTED_METHODS:
            work = [partial(run_start, curves, joint, method, i) for i in range(repeats)]
            work[0]()
            milliseconds = 1e3 * statistics.median(map(seconds, work))
            starts = [one for one in done if one.key[:2] == (joint, method)]
            found.append(_starts(starts, floor, milliseconds))
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


def _starts(starts: Sequence[Start], floor: float, milliseconds: float) -> Starts:
    (joint, method, _), *_ = (one.key for one in starts)
    evaluations = [one.evaluations for one in starts]
    reached = [
        next((spent for spent, best in one.history if best <= SUCCESS * floor), np.inf)
        for one in starts
    ]
    success_rate = float(np.mean([one.nrmse <= SUCCESS * floor for one in starts]))
    met = (
        max(evaluations) <= RUNS_LIMIT
        and milliseconds <= TIME_LIMIT
        and success_rate >= SUCCESS_LIMIT
    )
    return Starts(
        joint=joint,
        method=method,
        starts=len(starts),
        success_rate=success_rate,
        over_floor=float(np.median([one.nrmse for one in starts]) / floor),
        evaluations=float(np.median(evaluations)),
        most_evaluations=max(evaluations),
        to_target=float(np.quantile(reached, 0.5, method="higher")),
        milliseconds=milliseconds,
        met=met if method == "certified" else None,
    )
