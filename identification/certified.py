"""Our own fit: variable projection and bounded least squares, kept where a model is certified."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

from ..errors import InputError
from ..hysteresis._jiles_atherton_bulk import certificate
from ..hysteresis._jiles_atherton_envelope import margin_in_range
from .curves import Curve
from .objective import CurveObjective

Array = NDArray[np.float64]

# Search box. Angles in degrees, as in the paper's Table 1; the last coordinate is k (c - 1).
SHAPE = (3.0, 5000.0)  # a
STEEPNESS = (-1.9, 2.5)  # alpha (2c-1) Ms / (3a); below 1 (and above -2) safe at all angles
EXCESS = (0.01, 20.0)  # c - 1
REACH_LIMIT = 40_000.0  # k (c - 1); at least the start angle, so that the start is certified too

SCREENED = 32
DIFFERENCE = 1e-5
NOISE_MARGIN = 1.03
STALLED = 1e-5
AGREED = 1e-3  # two searches that end within this relative score found the same optimum
MARGIN = 0.01  # of the certificate, that a fit keeps
PENALTY = 10.0  # residual per missing margin: 0.01 of it weighs as much as 1 % noise in 100 samples
REJECTED = 10.0  # residual where the torque is infinite


@dataclass(frozen=True)
class CertifiedFit:
    """Result of `certified_fit`.

    Attributes:
        parameters: Ms, a, alpha, c, k in degrees.
        held: the range of angles [rad] outside which the torque must be held for the model to be
            certified; None if it is certified for all angles.
        nrmse: its score on the curves.
        evaluations: how often the model was evaluated on all curves.
        history: best score so far after each batch of evaluations.
    """

    parameters: Array
    held: tuple[float, float] | None
    nrmse: float
    evaluations: int
    history: list[float]


def certified_fit(
    curves: Sequence[Curve], *, rng: int | np.random.Generator | None = None, budget: int = 200
) -> CertifiedFit:
    """Fits a Jiles-Atherton model that no motion can drive into its pole.

    Torque is linear in Ms at fixed (a, alpha Ms, c, k), so Ms follows from a projection and four
    parameters remain. They are searched as log a, the certificate's steepness
    alpha (2c-1) Ms / (3a), log(c-1) and log(k(c-1)). What lacks a certificate, for all angles or at
    least for those of the curves, is penalized, and never returned. Sobol points are screened, then
    bounded least squares starts from the best ones in turn, until the residual is the measurement's
    own noise (estimated from second differences of the torque), two searches agree, or the budget
    is spent.

    Args:
        curves: first-order transition curves, each starting with zero torque.
        rng: seed or generator of the Sobol scrambling.
        budget: most evaluations of the model on all curves.

    Returns:
        The best parameters found, their NRMSE and how many evaluations they took.

    Raises:
        InputError: `budget` is too small, or the curves are unusable.
    """
    if budget <= SCREENED:
        raise InputError(f"budget is {budget}: use at least {SCREENED + 1} model evaluations")
    objective = CurveObjective(curves)
    projection = _Projection(objective, budget)
    low, high = _box(curves)
    sobol = qmc.Sobol(low.size, rng=np.random.default_rng(rng)).random(SCREENED)
    starts = low + sobol * (high - low)
    starts = starts[np.argsort(projection.scores(starts))]
    floor = noise_floor(curves) / objective.peak
    for start in starts:
        before = projection.best_score
        try:
            ended = projection.minimize(start, low, high)
        except _BudgetSpent:
            break
        if projection.best_score <= NOISE_MARGIN * floor or abs(ended / before - 1) < AGREED:
            break
    if not np.isfinite(projection.best_score):
        raise InputError(
            f"none of {objective.evaluations} models tried on these curves is certified: raise the "
            "budget, or check the columns and the sign of the torque"
        )
    safe = certificate(*projection.best)[0] >= MARGIN / 2
    return CertifiedFit(
        parameters=projection.best,
        held=None if safe else angle_range(curves),
        nrmse=projection.best_score,
        evaluations=objective.evaluations,
        history=projection.history,
    )


def angle_range(curves: Sequence[Curve]) -> tuple[float, float]:
    """Returns the smallest and the largest angle of some curves [rad]."""
    angle = np.concatenate([curve.angle for curve in curves])
    return float(angle.min()), float(angle.max())


def noise_floor(curves: Sequence[Curve]) -> float:
    """Estimates the standard deviation of the torque noise [N·m] from its second differences.

    The median makes it blind to the few samples at a reversal; smooth curves sampled densely
    contribute nothing.
    """
    second = np.concatenate([np.diff(curve.torque, 2) for curve in curves])
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6)) if second.size else 0.0


class _BudgetSpent(Exception):
    pass


class _Projection:
    """Residuals in search coordinates, with Ms projected out and the best point kept."""

    def __init__(self, objective: CurveObjective, budget: int) -> None:
        self.objective, self.budget = objective, budget
        self.range = np.degrees(angle_range(objective.curves))
        self.best, self.best_score = np.full(5, np.nan), np.inf
        self.history: list[float] = []

    def residuals(self, coordinates: Array) -> Array:
        """Returns (Tc - Tm) / max|Tm| and the penalty of each row, shape (n, samples + 1)."""
        if self.objective.evaluations + len(coordinates) > self.budget:
            raise _BudgetSpent
        parameters = _unit_parameters(coordinates)
        shape, torque = self.objective.responses(parameters), self.objective.torque
        power = np.einsum("ij,ij->i", shape, shape)
        Ms = np.maximum(shape @ torque, 1e-9 * power) / power
        parameters[:, 0], parameters[:, 2] = Ms, parameters[:, 2] / Ms
        residual = (Ms[:, None] * shape - torque) / self.objective.peak
        residual = np.where(np.isfinite(residual), residual, REJECTED)
        missing = np.array([self.missing_margin(row) for row in parameters])
        scores = np.sqrt(np.mean(residual**2, axis=1))
        scores[missing > MARGIN / 2] = np.inf
        winner = int(np.argmin(scores))
        if scores[winner] < self.best_score:
            self.best_score, self.best = float(scores[winner]), parameters[winner]
        self.history.append(self.best_score)
        return np.column_stack([residual, PENALTY * missing])

    def missing_margin(self, parameters: Array) -> float:
        """Returns by how much the certificate falls short of MARGIN, at best in the range."""
        if not np.isfinite(parameters).all():  # the torque is infinite, so Ms is not known
            return 1.0
        margin = certificate(*parameters)[0]
        if margin < MARGIN:
            margin = max(margin, margin_in_range(*self.range, *parameters)[0])
        return min(max(MARGIN - margin, 0.0), 1.0)

    def scores(self, coordinates: Array) -> Array:
        return np.sqrt(np.mean(self.residuals(coordinates) ** 2, axis=1))

    def minimize(self, start: Array, low: Array, high: Array) -> float:
        """Runs bounded least squares from `start`; returns the score where it ends."""
        result = least_squares(
            self.residual,
            start,
            jac=self.jacobian,  # type: ignore[arg-type]
            bounds=(low, high),
            x_scale="jac",
            ftol=STALLED,
            xtol=STALLED,
        )
        return float(np.sqrt(2 * result.cost / self.objective.torque.size))

    def residual(self, point: Array) -> Array:
        self.point, self.value = point.copy(), self.residuals(point[None])[0]
        return self.value

    def jacobian(self, point: Array) -> Array:
        value = self.value if np.array_equal(point, self.point) else self.residual(point)
        moved = point + DIFFERENCE * np.eye(point.size)
        return ((self.residuals(moved) - value) / DIFFERENCE).T


def _box(curves: Sequence[Curve]) -> tuple[Array, Array]:
    start = max(abs(float(np.degrees(curve.angle[0]))) for curve in curves)
    low = [np.log(SHAPE[0]), STEEPNESS[0], np.log(EXCESS[0]), np.log(max(start, 1.0))]
    high = [np.log(SHAPE[1]), STEEPNESS[1], np.log(EXCESS[1]), np.log(REACH_LIMIT)]
    return np.array(low), np.array(high)


def _unit_parameters(coordinates: Array) -> Array:
    """Maps search coordinates (n, 4) to parameters (n, 5) with Ms = 1."""
    log_a, steepness, log_excess, log_reach = coordinates.T
    a, excess = np.exp(log_a), np.exp(log_excess)
    alpha = steepness * 3 * a / (2 * excess + 1)
    return np.stack([np.ones_like(a), a, alpha, 1 + excess, np.exp(log_reach) / excess], axis=1)
