"""The likelihood of Jiles-Atherton parameters, and walks along its valleys."""

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.optimize import brentq, least_squares

from ...arrays import Array
from ...hysteresis.jiles_atherton.model import PARAMETERS
from ..fits.certified import TINY
from ..fits.objective import CurveObjective
from ..fits.search import REJECTED

CONVERGED = 1e-10
FIRST_STEP, FASTER = 0.5, 2.0  # longest first step of a walk, and its growth from step to step
LOST = 100.0  # multiple of the allowed growth at which a point is no start of the next fit
WIDEST = 10.0  # distance from the center beyond which no fit goes; extreme models take long
LEAST_NOISE = 1e-6  # share of the peak that curve files resolve
PRECISE = 1e-3  # tolerance of the end of a walk, relative to its length
MORE_ERROR = 0.01  # increase of the root mean square that counts as the same fit
LOOSE = np.log(1.1)  # change of a coordinate that is worth a sentence
FARTHEST = np.log(2)  # largest change of a coordinate in a sentence
SMALL = 0.05  # change of a coordinate that a sentence leaves out
ALIKE, ASIDE = 0.75, 0.5  # least ratio of two coordinates that move together; largest of the others
FACTORS = {0: "Ms", 1: "a", 3: "(c-1)", 4: "k"}  # coordinates that are logarithms


class Likelihood:
    """Least squares over y = log Ms, log a, alpha (Ms/a), log(c-1), log k, initial torque / peak.

    The Ms/a beside alpha is that of the row given; the last coordinate is there only if the initial
    torque is identified. Rows are those of `CurveObjective`.

    Attributes:
        objective: The curves.
        center: The point of the row given.
        best: The point of least squares near to it.
        cost: The sum of weighted squares there [(N·m)^2].
        variance: The variance of the torque at mean weight [(N·m)^2].
        freedom: Number of samples less that of the coordinates.
    """

    def __init__(self, objective: CurveObjective, row: Array) -> None:
        self.objective = objective
        self._weight = np.sqrt(objective.weight)
        Ms, a, alpha, c, k = row[:5].tolist()
        self._slope = Ms / a
        first = row[5:] / objective.peak
        logs = np.log(Ms), np.log(a), alpha * self._slope, np.log(c - 1), np.log(k)
        self.center = np.array([*logs, *first])
        self.freedom = objective.torque.size - self.center.size
        self.best, self.cost = self.minimize(self.center)
        self.variance = max(self.cost / self.freedom, (LEAST_NOISE * objective.peak) ** 2)

    def row(self, point: NDArray[Any]) -> NDArray[Any]:
        """Returns the parameters at a point."""
        log_Ms, log_a, alpha, log_excess, log_k = point[:5]
        Ms, a, excess, k = np.exp([log_Ms, log_a, log_excess, log_k])
        first = point[5:] * self.objective.peak
        return np.array([Ms, a, alpha / self._slope, 1 + excess, k, *first])

    def by_point(self, point: Array) -> Array:
        """Returns the derivative of each parameter with respect to its coordinate, shape (n,)."""
        return np.imag(self.row(point + TINY * 1j)) / TINY

    def residual(self, point: Array) -> Array:
        """Returns sqrt(w) (Tc - Tm) [N·m], shape (samples,)."""
        if self.is_extreme(point):
            return self._weight * REJECTED * self.objective.peak
        error = self.objective.responses(self.row(point))[0] - self.objective.torque
        return self._weight * np.where(np.isfinite(error), error, REJECTED * self.objective.peak)

    def is_extreme(self, point: Array) -> bool:
        """Returns whether a point is too far from the center to be tried."""
        return bool(np.abs(point - self.center).max() > WIDEST)

    def jacobian(self, point: Array) -> Array:
        """Returns the derivatives of `residual`, shape (samples, n)."""
        by_row = self.objective.derivatives(self.row(point)) * self._weight[:, None]
        return np.where(np.isfinite(by_row), by_row, 0.0) * self.by_point(point)

    def covariance(self, point: Array, prior: float = 0.0) -> Array:
        """Returns the covariance of the coordinates, linearized at a point, shape (n, n)."""
        _, singular, directions = np.linalg.svd(self.jacobian(point), full_matrices=False)
        known = singular**2 / self.variance  # 1 / variance of each direction
        return (directions.T / (known + prior)) @ directions

    def minimize(self, start: Array, fixed: Array | None = None) -> tuple[Array, float]:
        """Returns the best point near `start` and its cost.

        Args:
            start: Point to begin at, (n,).
            fixed: Directions in which not to move, (m, n).
        """
        if self.is_extreme(start):
            return start, np.inf
        ways = np.eye(start.size) if fixed is None else null_space(fixed)
        result = least_squares(
            lambda steps: self.residual(start + ways @ steps),
            np.zeros(ways.shape[1]),
            jac=lambda steps: self.jacobian(start + ways @ steps) @ ways,  # type: ignore[arg-type]
            method="lm",
            x_scale="jac",
            ftol=CONVERGED,
            xtol=CONVERGED,
        )
        return start + ways @ result.x, 2 * float(result.cost)

    def walk(
        self, direction: Array, growth: float, farthest: float, fixed: Array | None = None
    ) -> tuple[Array, bool]:
        """Walks from `best` in a direction, along the bottom of the valley.

        After each step all other directions are fitted anew.

        Args:
            direction: Direction of length 1, (n,).
            growth: Growth of the cost at which the walk ends [(N·m)^2].
            farthest: Largest distance in the direction.
            fixed: Other directions in which not to move, (m, n).

        Returns:
            The point where it ends, and whether the cost ended it.
        """
        kept = direction[None] if fixed is None else np.vstack([direction, fixed])
        covariance = self.covariance(self.best, prior=WIDEST**-2)
        spread = float(direction @ covariance @ direction)
        valley = covariance @ direction / spread

        @cache
        def bottom(distance: float) -> tuple[Array, float]:
            nonlocal valley
            if distance == 0:
                return self.best, -1.0
            point, cost = self.minimize(self.best + distance * valley, kept)
            if cost - self.cost < LOST * growth:
                valley = (point - self.best) / distance
            return point, float(np.sqrt(max(cost - self.cost, 0.0) / growth)) - 1

        def excess(distance: float) -> float:
            return bottom(distance)[1]

        inside = 0.0
        outside = min(np.sqrt(spread * growth / self.variance), FIRST_STEP, farthest)
        while excess(outside) < 0:
            if outside == farthest:
                return bottom(farthest)[0], False
            inside, outside = outside, min(FASTER * outside, farthest)
        end: Any = brentq(excess, inside, outside, xtol=PRECISE * outside)
        return bottom(float(end))[0], True


def sloppy_directions(
    likelihood: Likelihood, units: Array, unit_names: Sequence[str]
) -> Iterator[str]:
    """Yields a sentence for each combination of parameters that could change nearly unnoticed.

    The combinations are the singular vectors of the Jacobian, the loosest first. How far they go is
    not linearized: on the way the stiffer ones are fitted anew.

    Args:
        likelihood: The likelihood of the model.
        units: The units of the parameters in the sentences, shape (n,).
        unit_names: The units of the parameters that are given as differences; empty for the others.
    """
    names = (*PARAMETERS, "initial torque")
    growth = ((1 + MORE_ERROR) ** 2 - 1) * likelihood.variance * likelihood.freedom
    jacobian = likelihood.jacobian(likelihood.best)
    _, singular, directions = np.linalg.svd(jacobian, full_matrices=False)
    for i in reversed(range(singular.size)):
        largest = directions[i, np.argmax(np.abs(directions[i]))]
        if np.sqrt(growth) * abs(largest) < LOOSE * singular[i]:
            return
        direction = directions[i] * np.sign(largest)
        farthest = FARTHEST / abs(largest)
        end, _ = likelihood.walk(direction, growth, farthest, fixed=directions[i + 1 :])
        before, after = likelihood.row(likelihood.best), likelihood.row(end)
        change = end - likelihood.best
        parts = [
            f"{name} {(new - old) * unit:+.2g} {unit_name}"
            if unit_name
            else f"{name} {new / old - 1:+.0%}"
            for name, old, new, unit, unit_name, moved in zip(
                names, before, after, units, unit_names, change, strict=False
            )
            if abs(moved) >= SMALL
        ]
        if parts:
            raising = "together raise" if len(parts) > 1 else "raises"
            yield (
                f"{', '.join(parts)} {raising} the error by less than {MORE_ERROR:.0%}"
                f"{_known_of_two(change)}"
            )


def _known_of_two(change: Array) -> str:
    """Names the ratio or product that is still known, if mainly two factors change."""
    first, second, *others = np.argsort(-np.abs(change)).tolist()
    alike = abs(change[second]) >= ALIKE * abs(change[first])
    aside = np.abs(change[others]).max() <= ASIDE * abs(change[second])
    if not (alike and aside and first in FACTORS and second in FACTORS):
        return ""
    one, other = FACTORS[min(first, second)], FACTORS[max(first, second)]
    between = "/" if change[first] * change[second] > 0 else " "
    return f": of {one} and {other} hardly more than {one}{between}{other} is known"
