"""The search that all certified fits share, and the projection beside a polynomial."""

import math
from collections.abc import Callable, Iterable, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike
from scipy.optimize import least_squares, minimize_scalar, nnls

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ..data.curves import Curve, Curves, noise_floor, turns_back

MARGIN = 0.01  # margin of the certificate that a fit keeps
PENALTY = 10.0  # residual per missing margin: a margin of 0.01 weighs as 1 % noise in 100 samples
AGREED = 1e-3  # relative difference of scores within which two runs found the same optimum
REJECTED = 10.0  # residual in place of an infinite one
STALLED = 1e-5  # relative change of cost or point that ends one least-squares run
NOISE_MARGIN = 1.03  # ratio to the noise floor, below which a score is as good as the truth
DIFFERENCE = 1e-5  # step of a difference in place of a derivative
DERIVATIVES_COST = 3  # model runs; a response with all its derivatives takes the time of 1.7 to 2.3
AGREEING = 2  # runs that end at the same optimum, which ends the search
LEAST_SCALE = 1e-9  # least scale of the hysteretic part: a negative scale would drive the joint
FEWEST_BEYOND = 7  # least number of different angles less the degree, to determine the fits
SAME_START = 0.05  # largest distance of the beginnings of first-order curves, over the span


class Evaluation(NamedTuple):
    """Result of a problem at a point.

    Attributes:
        errors: The relative errors of the torque, (samples,).
        missing: The part of `MARGIN` that the certificate lacks.
        answer: Value that the search keeps if the point is the best one.
    """

    errors: Array
    missing: float
    answer: Array


class BudgetSpent(Exception):
    """The search has used up its evaluations."""


class Search:
    """Bounded least squares from several starts, which keeps the best certified point.

    A point that lacks more than half of `MARGIN` is penalized, and never the best.

    A problem has a box of coordinates, `low` and `high`, and `evaluate`, which runs the model of a
    point on all curves. A problem with exact derivatives also has `derivatives`, from a point to
    those of its errors, (samples, coordinates), and `missing`, from points (n, coordinates) to
    their missing margins, (n,).

    Args:
        problem: Problem to minimize.
        budget: Largest number of evaluations.
        exact: Whether the problem has exact derivatives; otherwise differences are taken.
        stalled: Relative change of cost or point that ends one least-squares run.

    Attributes:
        best: The answer of the best point so far; None before there is one.
        score: The root mean square of its errors.
        evaluations: How often the model ran; exact derivatives count as three runs.
        history: (evaluations, score) whenever the best one improved.
    """

    def __init__(
        self, problem: Any, budget: int, *, exact: bool = False, stalled: float = STALLED
    ) -> None:
        self.problem, self.budget, self.exact, self.stalled = problem, budget, exact, stalled
        self.best: Array | None = None
        self.score, self.evaluations = np.inf, 0
        self._ends: list[float] = []
        self.history: list[tuple[int, float]] = []

    @property
    def starts(self) -> int:
        """How many runs have ended."""
        return len(self._ends)

    @property
    def agreed(self) -> int:
        """How many runs ended at the best score, within 0.1 %, penalties included."""
        best = min(self._ends, default=np.inf)
        return sum(end <= (1 + AGREED) * best for end in self._ends)

    def spend(self, evaluations: int) -> None:
        """Counts model runs; raises `BudgetSpent` if the budget does not allow them."""
        if self.evaluations + evaluations > self.budget:
            raise BudgetSpent
        self.evaluations += evaluations

    def keep(self, answer: Array, score: float, missing: float) -> None:
        """Keeps an answer if it is certified and better than the best one so far."""
        if missing <= MARGIN / 2 and score < self.score:
            self.best, self.score = answer, score
            self.history.append((self.evaluations, score))

    def screened(self, points: Array) -> Array:
        """Evaluates points (n, coordinates); returns them with the best one first."""
        costs = np.array([np.mean(self.residual(point) ** 2) for point in points])
        return points[np.argsort(costs)]

    def run(self, starts: Iterable[Array], floor: float = 0.0, agreeing: int = 0) -> None:
        """Minimizes from each start in turn until one reason to end is met.

        Args:
            starts: Points to begin at, the most promising one first.
            floor: The noise; a score as low as the noise ends the search.
            agreeing: Number of runs within 0.1 % of the best score, and so at the same optimum, at
                which the search ends; 0 tries all starts.
        """
        try:
            for start in starts:
                self._ends.append(self._minimize(start))
                if self.score <= NOISE_MARGIN * floor:
                    return
                if agreeing and self.agreed >= agreeing:
                    return
        except BudgetSpent:
            return

    def residual(self, point: Array) -> Array:
        """Returns the errors of a point and its penalty, (samples + 1,)."""
        self.spend(1)
        errors, missing, answer = self.problem.evaluate(point)
        self.keep(answer, float(np.sqrt(np.mean(errors**2))), missing)
        self._point, self._value = point.copy(), np.append(errors, PENALTY * missing)
        return self._value

    def jacobian(self, point: Array) -> Array:
        """Returns the derivatives of `residual`, (samples + 1, coordinates)."""
        return self._exact(point) if self.exact else self._differences(point)

    def _minimize(self, start: Array) -> float:
        """Runs least squares from a start; returns the score, penalty included, where it ended.

        A coordinate with equal bounds is fixed.
        """
        free = self.problem.low < self.problem.high
        if not free.any():
            residual = self.residual(start)
            return float(np.sqrt(residual @ residual / (residual.size - 1)))

        def whole(moved: Array) -> Array:
            point = start.copy()
            point[free] = moved
            return point

        def slopes(moved: Array) -> Array:
            every = self.jacobian(whole(moved))
            return every if free.all() else every[:, free]

        result = least_squares(
            lambda moved: self.residual(whole(moved)),
            start[free],
            jac=slopes,  # type: ignore[arg-type]
            bounds=(self.problem.low[free], self.problem.high[free]),
            x_scale="jac",
            ftol=self.stalled,
            xtol=self.stalled,
        )
        return float(np.sqrt(2 * result.cost / (result.fun.size - 1)))

    def _exact(self, point: Array) -> Array:
        self.spend(DERIVATIVES_COST)
        errors = self.problem.derivatives(point)
        moved = point + DIFFERENCE * np.eye(point.size)
        missing = self.problem.missing(np.concatenate([point[None], moved]))
        return np.vstack([errors, PENALTY * (missing[1:] - missing[0]) / DIFFERENCE])

    def _differences(self, point: Array) -> Array:
        value = self._value if np.array_equal(point, self._point) else self.residual(point)
        # Away from the nearer bound, so that every point stays inside the box.
        middle = (self.problem.low + self.problem.high) / 2
        step = np.where(point > middle, -DIFFERENCE, DIFFERENCE)
        moves = zip(point + np.diag(step), self.problem.low < self.problem.high, strict=True)
        columns = [self.residual(moved) if is_free else value for moved, is_free in moves]
        return ((np.array(columns) - value) / step[:, None]).T


def sobol_points(
    low: Array, high: Array, count: int, rng: int | np.random.Generator | None
) -> Array:
    """Returns scrambled Sobol points in a box, (count, coordinates)."""
    from scipy.stats import qmc  # slow to import

    drawn = qmc.Sobol(low.size, rng=np.random.default_rng(rng)).random(count)
    return low + drawn * (high - low)


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
    beside: BesidePolynomial,
    box: ArrayLike,
    shape: Callable[[Array], Array],
    missing: Callable[[Array], float] = lambda _: 0.0,
    *,
    screened: int,
    budget: int,
    rng: int | np.random.Generator | None,
) -> Search:
    """Returns a finished search of the hysteretic torque that fits best beside a polynomial.

    The runs start from the best of some Sobol points, in turn.

    Args:
        beside: The curves, and the best polynomial on them; the noise of their torque ends the
            search.
        box: Lower and upper bound of each coordinate, shape (2, coordinates).
        shape: Function from a point to the hysteretic torque along all curves, (samples,).
        missing: Function from a point to the missing margin; by default every point is certified.
        screened: Number of Sobol points, a power of 2.
        budget: Largest number of evaluations.
        rng: Seed or generator of the Sobol scrambling.
    """
    at_least("budget", budget, screened + 1)

    def evaluate(point: Array) -> Evaluation:
        return Evaluation(beside.residual(shape(point)), missing(point), point.copy())

    low, high = np.array(box, dtype=np.float64)
    search = Search(SimpleNamespace(low=low, high=high, evaluate=evaluate), budget)
    starts = search.screened(sobol_points(low, high, screened, rng))
    search.run(starts, beside.floor, AGREEING)
    return search


def usable(curves: Sequence[Curve]) -> Curves:
    """Returns the curves with role "fit"."""
    chosen = Curves(curves).fitted()
    if not chosen:
        raise InputError("there is no curve to fit: give at least one with role 'fit'")
    if not any(np.ptp(curve.torque) > 0 for curve in chosen):
        raise InputError("no torque changes along its curve: there is nothing to identify")
    if not any(map(turns_back, chosen)):
        raise InputError("no curve turns back, so nothing shows the hysteresis: measure the return")
    return chosen


def least_of(grid: Array, loss: Callable[[float], float]) -> float:
    """Returns the best of a grid (n,), refined by Brent's bounded search in logarithms."""
    best = int(np.argmin([loss(point) for point in grid.tolist()]))
    near = np.log(grid[[max(best - 1, 0), min(best + 1, grid.size - 1)]])
    found: Any = minimize_scalar(lambda log: loss(math.exp(log)), bounds=near, method="bounded")
    return math.exp(found.x)
