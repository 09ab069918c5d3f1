"""Change of a torque over the cycles of a measurement: its estimate and its removal."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.loops import reversals
from ..data.curves import Curve, Curves
from ..fits.objective import predicted, price
from ..fits.registry import Fitted
from ..fits.search import least_of
from ..fits.tangent import beside, coordinates_of, independent, tangent

Softens = Literal["none", "fit"]
FEWEST = 2.0  # fewest cycles in which a change is identifiable
# Shortest and longest decay of the change to 1/e, in cycles and as a multiple of all cycles.
SHORTEST, LONGEST = 0.5, 3.0
TIMES = 12  # number of decays on the grid between them
ROUNDS = 12  # largest number of rounds; 3 are usual
CONVERGED = 1e-4  # change of the factor between rounds at convergence
MOST = 9.99  # largest ratio of first and steady torque, either way: just within a suit file's
NEARLY = 0.995  # sufficient share of the fewest cycles, as records end a sample early
UNSETTLED = 0.2  # share of the change that may remain at the end of the curves


class Softening(NamedTuple):
    """How the torque changes over cycles, relative to the torque at the end of the curves.

    After n cycles the torque is steady + (first - steady) exp(-n / cycles) times the model's.
    """

    first: float  # torque of the first cycle
    steady: float  # torque after many cycles
    cycles: float  # number of cycles in which the difference falls to 1/e
    measured: float  # number of cycles of the curves

    def factor(self, cycles: Array) -> Array:
        """Returns the torque after some cycles, over the torque of the model."""
        return self.steady + (self.first - self.steady) * np.exp(-cycles / self.cycles)

    @property
    def is_complete(self) -> bool:
        """Whether little of the change remained at the end of the curves."""
        return math.exp(-self.measured / self.cycles) <= UNSETTLED


class Count:
    """Cycles over the range of all curves that a joint has gone through, in their order."""

    def __init__(self, curves: Curves) -> None:
        low, high = curves.angle_range
        self._cycle, self._before, total = 2 * (high - low), dict[str, float](), 0.0
        for curve in curves:
            self._before[curve.name] = total
            total += float(_way(curve.angle)[-1]) / self._cycle
        self.total = total

    def __call__(self, curve: Curve) -> Array:
        """Returns the cycles up to each sample of one of the curves, shape (n,)."""
        return self._before[curve.name] + _way(curve.angle) / self._cycle


def without_change(curves: Curves, softening: Softening, count: Count) -> Curves:
    """Returns curves with the torques of the end of the measurement."""
    rest = (
        replace(curve, torque=curve.torque / softening.factor(count(curve))) for curve in curves
    )
    return curves.of(rest)


def found_softening(
    curves: Curves, count: Count, fit: Callable[[Curves], Fitted]
) -> Softening | None:
    """Returns how the torque changes over the cycles of curves; None without such a change.

    Two fits alternate: of the model to the torque without the change, and of the change beside the
    derivatives of the torque with respect to the model's parameters (variable projection, Golub and
    Pereyra 1973). The decay, in cycles, is refined from the best of a grid. A change that lowers
    the error by less than the cost of its two parameters (the Bayesian information criterion) does
    not count.
    """
    if count.total < NEARLY * FEWEST:
        raise InputError(
            f"the curves go through {count.total:.3g} cycles of their range: a change from cycle "
            f"to cycle needs at least {FEWEST:g}; measure more, or leave softening out"
        )
    without = fit(curves)
    slow, found = without, Softening(1.0, 1.0, count.total, count.total)
    for _ in range(ROUNDS):
        before, found = found, _change(slow, curves, count)
        if max(abs(found.first - before.first), abs(found.steady - before.steady)) <= CONVERGED:
            break
        slow = fit(without_change(curves, found, count))
    samples = sum(curve.angle.size for curve in curves)
    constant = Softening(1.0, 1.0, count.total, count.total)
    worth = _error(without, constant, curves, count) / _error(slow, found, curves, count)
    return found if worth > price(2, samples) else None


def _change(slow: Fitted, curves: Curves, count: Count) -> Softening:
    """Returns the change that best explains the residual of a model."""
    model, start = slow.model, slow.initial_torque
    torque = np.concatenate([predicted(model, start, curve) for curve in curves])
    rest = np.concatenate([curve.torque for curve in curves]) - torque
    gone, total = np.concatenate([count(curve) for curve in curves]), count.total
    if not np.isfinite(rest).all():
        return Softening(1.0, 1.0, total, total)
    slopes = tangent(coordinates_of(model, start, fitted_start=True), curves)
    basis = independent(slopes)
    squares = max(float(torque @ torque), np.finfo(float).tiny)
    goal = beside(basis, rest)

    def tried(cycles: float) -> tuple[float, Softening]:
        left = math.exp(-total / cycles)
        column = torque * (np.exp(-gone / cycles) - left)
        alone = beside(basis, column)
        size = float(alone @ goal) / max(float(alone @ alone), np.finfo(float).tiny)
        # The model fits the mean of the torque, and the change is relative to the end.
        end = max(1 + float(torque @ (rest - size * column)) / squares, 1 / MOST)
        # Neither of first and steady is more than MOST times the other.
        low, high = -1 / (1 - left + 1 / (MOST - 1)), 1 / (left + 1 / (MOST - 1))
        change = min(max(size / end, low), high)
        error = float(np.sum((goal - change * end * alone) ** 2))
        return error, Softening(1 + change * (1 - left), 1 - change * left, cycles, total)

    grid = np.geomspace(SHORTEST, LONGEST * total, TIMES)
    return tried(least_of(grid, lambda cycles: tried(cycles)[0]))[1]


def _error(slow: Fitted, softening: Softening, curves: Sequence[Curve], count: Count) -> float:
    """Returns the root mean square of predicted less measured torque [N·m]."""
    errors = [
        softening.factor(count(curve)) * predicted(slow.model, slow.initial_torque, curve)
        - curve.torque
        for curve in curves
    ]
    return float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))


def _way(angle: Array) -> Array:
    """Returns the distance that a motion has covered, less the noise of its angle [rad], (n,)."""
    ends = [0, *reversals(angle).tolist(), angle.size - 1]
    way = np.zeros_like(angle)
    for begin, end in pairwise(ends):
        branch = np.abs(angle[begin : end + 1] - angle[begin])
        way[begin : end + 1] = way[begin] + np.maximum.accumulate(branch)
    return way
