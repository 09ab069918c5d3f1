"""The projection and the search that all fits beside an elastic polynomial use."""

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import nnls

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ..curves import Curve, noise_floor
from .linear import SAME_START, usable
from .search import REJECTED, Problem, Search, sobol_points

AGREEING = 2  # runs that end at the same optimum, which ends the search
LEAST_SCALE = 1e-9  # least scale of the hysteretic part, in place of one that would drive the joint
FEWEST_BEYOND = 7  # least excess of angles over the degree, so that the fits are determined


class BesidePolynomial:
    """The best scale of a hysteretic torque beside the best polynomial of the angle.

    Attributes:
        curves: The curves with role "fit", which begin at one angle.
        start: Angle at which the curves begin [rad].
        peak: The largest |torque| [N·m].
        floor: The noise of the torque over the peak.
    """

    def __init__(self, curves: Sequence[Curve], degree: int) -> None:
        self.curves = usable(curves)
        self.start = common_start(self.curves)
        self.low, self.high = self.curves.angle_range
        self.angle = np.concatenate([curve.angle for curve in self.curves])
        self.starts = np.cumsum([0] + [curve.angle.size for curve in self.curves])
        self.torque = np.concatenate([curve.torque for curve in self.curves])
        fewest = degree + FEWEST_BEYOND
        if np.unique(self.angle).size < fewest:
            raise InputError(
                f"the fitted curves have samples at {np.unique(self.angle).size} different angles: "
                f"give at least {fewest}"
            )
        self.peak = self.curves.peak
        self.floor = noise_floor(self.curves) / self.peak
        centered = (2 * self.angle - self.low - self.high) / (self.high - self.low)
        self._basis, self._triangle = np.linalg.qr(np.vander(centered, degree + 1, increasing=True))
        self._rest = self._without(self.torque)

    def scale(self, shape: Array) -> float:
        """Returns the factor above 0 that fits a hysteretic torque `shape` (samples,) best."""
        shape = self._without(shape)
        power = max(float(shape @ shape), np.finfo(float).tiny)
        return max(float(shape @ self._rest) / power, LEAST_SCALE)

    def weights(self, shapes: Array) -> Array:
        """Returns the weights above 0 with which shapes (samples, n) fit best together, (n,)."""
        found, _ = nnls(self._without(shapes), self._rest)
        return np.maximum(found, LEAST_SCALE)

    def residual(self, shape: Array) -> Array:
        """Returns (Tc - Tm) / max|Tm| with the best scale and polynomial, shape (samples,)."""
        if not np.isfinite(shape).all():
            return np.full(shape.size, REJECTED)
        return (self.scale(shape) * self._without(shape) - self._rest) / self.peak

    def polynomial(self, shape: Array) -> list[float]:
        """Returns the coefficients p_0, p_1, ... [N·m/rad^i] that go with the best scale."""
        left = self.torque - self.scale(shape) * shape
        centered = np.linalg.solve(self._triangle, self._basis.T @ left)
        converted = Polynomial(centered, domain=[self.low, self.high]).convert()
        return np.pad(converted.coef, (0, centered.size - converted.coef.size)).tolist()

    def _without(self, values: Array) -> Array:
        return values - self._basis @ (self._basis.T @ values)


def common_start(curves: Sequence[Curve]) -> float:
    """Returns the angle [rad] at which all curves begin."""
    starts = [float(curve.angle[0]) for curve in curves]
    reach = max(float(np.abs(curve.angle - curve.angle[0]).max()) for curve in curves)
    if np.ptp(starts) > SAME_START * reach:
        raise InputError(
            f"the curves begin at {min(starts):.6g} to {max(starts):.6g} rad: first-order curves "
            "begin at one angle; give such a family"
        )
    return float(np.mean(starts))


def search_shapes(
    problem: Problem,
    floor: float,
    *,
    screened: int,
    budget: int,
    rng: int | np.random.Generator | None,
) -> Search:
    """Returns a finished search from the best of some Sobol points, in turn.

    Args:
        problem: The errors of the shapes, with the projection done.
        floor: The noise of the torque over the peak, which ends the search.
        screened: The number of Sobol points, a power of 2.
        budget: Largest number of evaluations.
        rng: Seed or generator of the Sobol scrambling.
    """
    at_least("budget", budget, screened + 1)
    search = Search(problem, budget)
    starts = search.screened(sobol_points(problem.low, problem.high, screened, rng))
    search.run(starts, floor, AGREEING)
    return search
