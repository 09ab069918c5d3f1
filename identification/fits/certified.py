"""The certified fit of Jiles-Atherton: least squares with exact derivatives, of safe models."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ...hysteresis.around import Clipped
from ...hysteresis.jiles_atherton import coordinates
from ...hysteresis.jiles_atherton.coordinates import LOG_EXCESS, LOG_MS, LOG_REACH, STEEPNESS
from ...hysteresis.jiles_atherton.langevin import langevin
from ...hysteresis.jiles_atherton.margins import margin_everywhere, margin_in_range
from ...hysteresis.jiles_atherton.model import PARAMETERS, JilesAtherton
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves, noise_floor
from .objective import CurveObjective, Fitted, InitialTorque, torque_errors
from .parameters import FREE, Constraints
from .search import MARGIN, PENALTY, REJECTED, Evaluation, Search, sobol_points

BEGINNINGS = 1001  # number of torques tried in each direction, up to the peak of the curves
# Search box, in the coordinates of `hysteresis.jiles_atherton.coordinates`; angles in degrees, as
# in the paper's Table 1.
SHAPE = (3.0, 5000.0)  # a
BEND = (-1.9, 2.5)  # steepness; models above 1 are safe in a range of angles only
EXCESS = (0.01, 20.0)  # c - 1
REACH_LIMIT = 40_000.0  # k (c - 1); at least the start angle, so that the start is certified too
SCREENED = 32
AGREEING = 5  # runs that end at the same optimum, which ends the search
BUDGET = 2_000  # evaluations; usual are 80 to 300, and some truths need more
REFINED = 200  # evaluations from one start
TINY = 1e-30
LEAST_START, LEAST = 1e-6, 1e-9  # Ms over the peak, where a search starts and on its way
MOST = 1e9


def common_torque(model: HysteresisModel, curves: Sequence[Curve]) -> float:
    """Returns the one initial torque [N·m] with which a model fits all curves best.

    The first sample of a curve would bring its whole noise into a prediction. If the certificate
    does not cover the best initial torque, the nearest one that the certificate covers is returned.
    """

    def residual(torque: Array) -> Array:
        try:
            errors = torque_errors(model, float(torque[0]), curves)
        except InputError:  # the model cannot begin so
            errors = np.full(samples, np.inf)
        return np.where(np.isfinite(errors), errors, REJECTED * size)

    guess = np.median([curve.torque[0] for curve in curves])
    size = Curves(curves).peak
    samples = sum(curve.torque.size for curve in curves)
    best = float(least_squares(residual, [guess], x_scale=size).x[0])
    for distance in np.linspace(0, size, BEGINNINGS).tolist():
        for torque in (best - distance, best + distance):
            if begins_safely(model, torque, curves):
                return torque
    raise InputError(
        f"the fitted {model.name} model cannot begin as the curves do, at {best:.3g} N·m: check "
        "the sign of the torque, or measure curves that begin nearer to the torque at rest"
    )


def begins_safely(model: HysteresisModel, torque: float, curves: Sequence[Curve]) -> bool:
    """Returns whether a model can begin all curves with a torque [N·m], within its certificate."""
    try:
        states = [model.start(float(curve.angle[0]), torque) for curve in curves]
    except InputError:  # the model cannot have that torque there
        return False
    return all(model.start_is_certified(state) for state in states)


def bare(model: HysteresisModel) -> JilesAtherton:
    """Returns the Jiles-Atherton model of a fit, without the constant torque outside a range."""
    inner = model.model if isinstance(model, Clipped) else model
    if not isinstance(inner, JilesAtherton):
        raise InputError(
            f"model is {model.name!r}: give a Jiles-Atherton model, with or without an angle range"
        )
    return inner


def paper_model(parameters: ArrayLike) -> JilesAtherton:
    """Returns the model of one parameter row (Ms, a, alpha, c, k) in degrees, whatever its c."""
    Ms, a, alpha, c, k = np.asarray(parameters, dtype=np.float64).tolist()
    return JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg", allow_active=c < 1)


def certified_fit(
    curves: Sequence[Curve],
    *,
    rng: int | np.random.Generator | None = None,
    budget: int = BUDGET,
    initial_torque: InitialTorque = 0.0,
    constraints: Constraints = FREE,
) -> Fitted:
    """Fits a Jiles-Atherton model that no motion can drive into its pole.

    The parameters are searched as log a, the certificate's steepness alpha (2c-1) Ms / (3a),
    log(c-1), log(k(c-1)) and log Ms. Models without a certificate, for all angles or at least for
    those of the curves, are penalized and never returned. Sobol points of the first four are
    screened; Ms follows from a projection, because the torque of a motion that begins without
    torque is linear in Ms at fixed (a, alpha Ms, c, k). Bounded least squares with exact
    derivatives starts from the best ones in turn, until the residual is the measurement's own noise
    (estimated from second differences of the torque), or the budget is spent: runs that agree may
    all be wrong.

    Args:
        curves: The measured curves.
        rng: Seed or generator of the Sobol scrambling.
        budget: Largest number of evaluations of the model on all curves.
        initial_torque: The torque with which every curve begins [N·m]; "measured" is each
            curve's first sample, "identified" searches one torque for all curves.
        constraints: Parameters that are fixed or bounded, angles in degrees. For such a k or alpha
            the search has log k or alpha in place of log(k(c-1)) or the steepness.

    Returns:
        The certified model, with constant torque outside the angles of the curves if it is safe
        inside only. `loss` is sqrt(mean(w (Tc - Tm)^2)) / max|Tm| with weights w of mean 1; a
        response with all its derivatives counts as three evaluations; `history` has the pair
        (evaluations, loss) of each improvement.
    """
    at_least("budget", budget, SCREENED * (2 if constraints else 1) + 1)
    problem = CertifiedProblem(curves, initial_torque, constraints)
    search = Search(problem, budget, exact=True)
    floor = noise_floor(curves) / problem.objective.peak
    search.run(problem.starts(search, rng), floor, AGREEING)
    return problem.result(search)


def refined(
    curves: Sequence[Curve],
    row: Array,
    *,
    initial_torque: InitialTorque = 0.0,
    constraints: Constraints = FREE,
) -> Fitted:
    """Fits as `certified_fit` does, from one start: a row of parameters of `CurveObjective`."""
    problem = CertifiedProblem(curves, initial_torque, constraints)
    search = Search(problem, REFINED, exact=True)
    search.run([problem.point(row)])
    return problem.result(search)


class CertifiedProblem:
    """The errors of Jiles-Atherton models on curves, and their missing margins.

    A point has the five coordinates of `hysteresis.jiles_atherton.coordinates` and, if identified,
    the initial torque over the peak. For a fixed or bounded alpha or k, the point has alpha in
    place of the steepness, or log k in place of log(k(c-1)). A row is Ms, a, alpha, c, k in degrees
    and, if identified, the initial torque.
    """

    def __init__(
        self,
        curves: Sequence[Curve],
        initial_torque: InitialTorque,
        constraints: Constraints = FREE,
    ) -> None:
        self.objective = CurveObjective(curves, initial_torque=initial_torque)
        self.scale = np.sqrt(self.objective.weight) / self.objective.peak
        self.angle_range = Curves(curves).angle_range
        self.degrees: tuple[float, float] = tuple(np.degrees(self.angle_range).tolist())
        self.first_angles = np.degrees([curve.angle[0] for curve in curves])
        self.constraints, self.has_k = constraints, constraints.has("k")
        self.has_alpha = constraints.has("alpha")
        self.ends = np.array([constraints.ends(name) for name in PARAMETERS]).T
        low, high = self.shape_box = shape_box(curves, constraints)
        self.least_reach = low[LOG_REACH]
        others = [np.inf, 1.0][: 1 + (initial_torque == "identified")]
        self.low, self.high = np.append(low, np.negative(others)), np.append(high, others)
        if constraints:
            ends = constraints.box("Ms", (0.0, np.inf), 0.0)
            with np.errstate(divide="ignore"):
                self.low[LOG_MS], self.high[LOG_MS] = np.log(ends)
        if self.has_alpha:
            ends = constraints.ends("alpha")
            self.low[STEEPNESS], self.high[STEEPNESS] = ends
        if self.has_k:
            usual = np.exp(low[LOG_REACH] - high[LOG_EXCESS]), REACH_LIMIT / EXCESS[0]
            ends = np.log(constraints.box("k", usual, 0.0))
            self.low[LOG_REACH], self.high[LOG_REACH] = ends

    def evaluate(self, point: Array) -> Evaluation:
        """Returns sqrt(w) (Tc - Tm) / max|Tm| along all curves, the missing margin, and the row."""
        size = point[4] - np.log(self.objective.peak)
        if not np.log(LEAST) <= size <= np.log(MOST):  # curves that drive the joint lead here
            return Evaluation(np.full(self.objective.torque.size, REJECTED), 1.0, point)
        (row,) = self.rows(point[None])
        errors = (self.objective.responses(row)[0] - self.objective.torque) * self.scale
        errors = np.where(np.isfinite(errors), errors, REJECTED)
        missing = self.missing_margin(row, self.objective.first_torques(row))
        return Evaluation(errors, missing, row)

    def derivatives(self, point: Array) -> Array:
        """Returns the exact derivatives of the errors, (samples, coordinates)."""
        (row,) = self.rows(point[None])
        by_row = self.objective.derivatives(row) * self.scale[:, None]
        # An infinitesimal imaginary step differentiates the coordinates exactly.
        by_coordinate = np.imag(self.rows(point + TINY * 1j * np.eye(point.size))).T / TINY
        return np.where(np.isfinite(by_row), by_row, 0.0) @ by_coordinate

    def missing(self, points: Array) -> Array:
        """Returns the margins that points (n, coordinates) lack, (n,)."""
        first_torques = self.objective.first_torques
        return np.array([self.missing_margin(r, first_torques(r)) for r in self.rows(points)])

    def starts(self, search: Search, rng: int | np.random.Generator | None) -> Array:
        """Screens Sobol points of the shape; returns starts, the best first."""
        search.spend(SCREENED)
        points = sobol_points(*self.shape_box, SCREENED, rng)
        rows = coordinates.unit_rows(points)
        shape = CurveObjective(self.objective.curves).responses(rows) * self.scale
        torque = self.objective.torque * self.scale
        power = np.einsum("ij,ij->i", shape, shape)
        Ms = np.maximum(shape @ torque / power, LEAST_START * self.objective.peak)
        scores = np.sqrt(np.mean((Ms[:, None] * shape - torque) ** 2, axis=1))
        Ms = np.where(np.isfinite(Ms), Ms, self.objective.peak)
        rows[:, 0], rows[:, 2] = Ms, rows[:, 2] / Ms
        missing = np.array([self.missing_margin(row, np.zeros(1)) for row in rows])
        first = float(np.mean([curve.torque[0] for curve in self.objective.curves]))
        if self.constraints:
            begun = np.column_stack([rows, np.full(SCREENED, first)])
            return search.screened(np.array([self.point(row) for row in begun]))
        if self.objective.initial_torque == 0:
            for row, score, lacking in zip(rows, scores, missing, strict=True):
                search.keep(row, score, lacking)
        starts = np.column_stack(
            [points, np.log(Ms), np.full(SCREENED, first / self.objective.peak)]
        )
        costs = torque.size * scores**2 + (PENALTY * missing) ** 2
        return starts[np.argsort(costs), : self.low.size]  # NaN costs, past the pole, are last

    def rows(self, points: NDArray[Any]) -> NDArray[Any]:
        """Returns the rows of points, which may be complex."""
        shapes, first = points[:, :5], points[:, 5:] * self.objective.peak
        if self.constraints:
            shapes = shapes.copy()
            log_a, _, log_excess, _, log_Ms = shapes.T
            if self.has_k:
                shapes[:, LOG_REACH] += log_excess
            if self.has_alpha:
                shapes[:, STEEPNESS] *= (2 * np.exp(log_excess) + 1) * np.exp(log_Ms - log_a) / 3
        models = coordinates.rows(shapes)
        if self.constraints and not np.iscomplexobj(models):
            models = np.clip(models, *self.ends)
        return np.concatenate([models, first], axis=1) if first.size else models

    def point(self, row: Array) -> Array:
        """Returns the point of a row, moved into the box."""
        found = [*coordinates.point(row[:5]), *row[5:] / self.objective.peak][: self.low.size]
        if self.has_k:
            found[LOG_REACH] -= found[LOG_EXCESS]
        if self.has_alpha:
            found[STEEPNESS] = row[2]
        return np.clip(found, self.low, self.high)

    def missing_margin(self, row: Array, first: Array) -> float:
        """Returns the margin that a row lacks, for all angles or in the range: the smaller one."""
        missing = missing_margin(row, first, self.first_angles, self.degrees)
        if not self.has_k:
            return missing
        short = self.least_reach - np.log(row[4] * (row[3] - 1))  # of a start without torque
        return max(missing, min(float(short) + MARGIN / 2, 1.0))

    def result(self, search: Search) -> Fitted:
        """Returns the model that a search found, safe everywhere or in the angles of the curves."""
        if search.best is None:
            raise InputError(
                f"none of {search.evaluations} models tried on these curves is certified: raise "
                "the budget, or check the columns, the sign of the torque and the initial torque"
            )
        row, first = search.best[:5], self.objective.first_torques(search.best)
        model: HysteresisModel = JilesAtherton(
            **dict(zip(PARAMETERS, row.tolist(), strict=True)), angle_unit="deg"
        )
        if shortfall(search.best, first, self.first_angles) > MARGIN / 2:
            model = Clipped(model=model, angle_range=self.angle_range)
        measured = self.objective.initial_torque == "measured"
        start: InitialTorque = "measured" if measured else float(first[0])
        counts = search.evaluations, search.agreed, search.starts
        return Fitted(model, start, search.score, *counts, tuple(search.history))


def missing_margin(
    row: Array, first: Array | float, angles: Array, inside: tuple[float, float]
) -> float:
    """Returns the margin that a model lacks for all angles or in a range: the smaller one.

    The row is Ms, a, alpha, c, k in degrees (further numbers are ignored), `first` and `angles` are
    the torque [N·m] and the angle [deg] at the beginning of each curve, and `inside` is the range
    [deg].
    """
    missing = shortfall(row, first, angles)
    return missing and min(missing, shortfall(row, first, angles, inside))


def shortfall(
    row: Array, first: Array | float, angles: Array, inside: tuple[float, float] | None = None
) -> float:
    """Returns how much of MARGIN the certificate lacks; an unsafe start counts as MARGIN / 2."""
    Ms, a, alpha, c, k = row[:5].tolist()
    if inside is None:
        margin, bound = margin_everywhere(Ms, a, alpha, c, k)
    else:
        margin, bound, _ = margin_in_range(*inside, Ms, a, alpha, c, k)
    lags = [
        abs(torque - Ms * langevin((angle + alpha * torque) / a)[0])
        for angle, torque in np.broadcast(angles, first)
        if torque  # the box keeps all starts without torque inside the bound
    ]
    excess = (max(lags, default=-np.inf) - bound) / Ms
    return min(max(MARGIN - margin, MARGIN / 2 + excess, 0.0), 1.0)


def shape_box(curves: Sequence[Curve], constraints: Constraints = FREE) -> tuple[Array, Array]:
    """Returns the lower and upper bounds of the first four coordinates, (4,) each."""
    start = max(abs(float(np.degrees(curve.angle[0]))) for curve in curves)
    a, excess = constraints.box("a", SHAPE, 0.0), EXCESS
    if constraints.has("c"):
        low_c, high_c = constraints.box("c", (1 + EXCESS[0], 1 + EXCESS[1]), 1.0)
        excess = low_c - 1, high_c - 1
    low = [np.log(a[0]), BEND[0], np.log(excess[0]), np.log(max(start, 1.0))]
    high = [np.log(a[1]), BEND[1], np.log(excess[1]), np.log(REACH_LIMIT)]
    return np.array(low), np.array(high)
