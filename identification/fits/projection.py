"""What fits beside an elastic polynomial share: its projection, and the search over shapes."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial import Polynomial
from scipy.optimize import least_squares

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ..curves import Curve, noise_floor
from .certified import DIFFERENCE, MARGIN, NOISE_MARGIN, PENALTY, REJECTED, STALLED
from .linear import SAME_START, usable

AGREED = 1e-3  # two searches that end within this relative score found the same optimum
LEAST_SCALE = 1e-9  # of the hysteretic part, in place of one that would drive the joint
FEWEST_BEYOND = 7  # angles that take part, so that the fits leave nothing open


class BesidePolynomial:
    """The best scale of a hysteretic torque beside the best polynomial of the angle.

    Attributes:
        curves: those with role "fit", which begin at one angle.
        start: that angle [rad].
        peak: the largest |torque| [N·m].
        floor: the noise of the torque over the peak.
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
    """Returns the angle [rad] at which all curves begin.

    Raises:
        InputError: they begin apart.
    """
    starts = [float(curve.angle[0]) for curve in curves]
    reach = max(float(np.abs(curve.angle - curve.angle[0]).max()) for curve in curves)
    if np.ptp(starts) > SAME_START * reach:
        raise InputError(
            f"the curves begin at {min(starts):.6g} to {max(starts):.6g} rad: first-order curves "
            "begin at one angle; give such a family"
        )
    return float(np.mean(starts))


class BudgetSpent(Exception):
    """The search has used up its evaluations."""


class Search:
    """Bounded least squares from the best of some Sobol points, in turn.

    Attributes:
        best: the best allowed point so far; None before there is one.
        score: its root mean square residual.
        evaluations: how many points were evaluated.
    """

    def __init__(
        self, evaluate: Callable[[Array], tuple[Array, float]], low: Array, high: Array, budget: int
    ) -> None:
        """Prepares a search.

        Args:
            evaluate: takes a point to its residuals (samples,) and the margin [1] that it lacks;
                what lacks more than half of `MARGIN` is never the best.
            low: lower bounds (d,).
            high: upper bounds (d,).
            budget: most evaluations.
        """
        self.evaluate, self.low, self.high, self.budget = evaluate, low, high, budget
        self.best: Array | None = None
        self.score, self.evaluations = np.inf, 0

    def run(self, rng: int | np.random.Generator | None, screened: int, floor: float) -> None:
        """Searches until the score is the noise `floor`, two searches agree, or the budget ends.

        Raises:
            InputError: the budget does not suffice for the screening.
        """
        at_least("budget", self.budget, screened + 1)
        from scipy.stats import qmc  # slow to import

        sobol = qmc.Sobol(self.low.size, rng=np.random.default_rng(rng)).random(screened)
        points = self.low + sobol * (self.high - self.low)
        costs = [np.mean(self._residual(point) ** 2) for point in points]
        try:
            for point in points[np.argsort(costs)]:
                before = self.score
                ended = self._minimize(point)
                if self.score <= NOISE_MARGIN * floor or abs(ended / before - 1) < AGREED:
                    return
        except BudgetSpent:
            return

    def _minimize(self, start: Array) -> float:
        result = least_squares(
            self._residual,
            start,
            jac=self._jacobian,  # type: ignore[arg-type]
            bounds=(self.low, self.high),
            x_scale="jac",
            ftol=STALLED,
            xtol=STALLED,
        )
        return float(np.sqrt(2 * result.cost / (result.fun.size - 1)))

    def _residual(self, point: Array) -> Array:
        if self.evaluations >= self.budget:
            raise BudgetSpent
        self.evaluations += 1
        residual, missing = self.evaluate(point)
        score = float(np.sqrt(np.mean(residual**2)))
        if missing <= MARGIN / 2 and score < self.score:
            self.best, self.score = point.copy(), score
        self._point, self._value = point.copy(), np.append(residual, PENALTY * missing)
        return self._value

    def _jacobian(self, point: Array) -> Array:
        value = self._value if np.array_equal(point, self._point) else self._residual(point)
        # Away from the nearer bound, so that every point stays inside the box.
        step = np.where(point > (self.low + self.high) / 2, -DIFFERENCE, DIFFERENCE)
        columns = [self._residual(moved) for moved in point + np.diag(step)]
        return ((np.array(columns) - value) / step[:, None]).T
