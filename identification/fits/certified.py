"""Our own fit: bounded least squares with exact derivatives, kept where a model is certified."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.around.held import Held
from ...hysteresis.jiles_atherton.langevin import langevin
from ...hysteresis.jiles_atherton.margins import margin_everywhere, margin_in_range
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ..curves import Curve, Curves, noise_floor
from ..objective import CurveObjective, InitialTorque

# Search box. Angles in degrees, as in the paper's Table 1; the last coordinate is k (c - 1).
SHAPE = (3.0, 5000.0)  # a
STEEPNESS = (-1.9, 2.5)  # alpha (2c-1) Ms / (3a); below 1 (and above -2) safe at all angles
EXCESS = (0.01, 20.0)  # c - 1
REACH_LIMIT = 40_000.0  # k (c - 1); at least the start angle, so that the start is certified too

SCREENED = 32
DERIVATIVES_COST = 3  # model runs; a response with all its derivatives takes the time of 1.7 to 2.3
DIFFERENCE = 1e-5  # where nothing better is at hand
TINY = 1e-30
NOISE_MARGIN = 1.03
STALLED = 1e-5
MARGIN = 0.01  # of the certificate, that a fit keeps
PENALTY = 10.0  # residual per missing margin: 0.01 of it weighs as much as 1 % noise in 100 samples
REJECTED = 10.0  # residual where the torque is infinite, or Ms below its limit
LEAST_START, LEAST = 1e-6, 1e-9  # Ms over the peak, where a search starts and on its way


@dataclass(frozen=True, kw_only=True)
class CertifiedFit:
    """Result of `certified_fit`.

    Attributes:
        parameters: Ms, a, alpha, c, k in degrees, shape (5,).
        initial_torque: the torque with which every curve begins [N·m]; or "measured": each begins
            with its first sample.
        held: the range of angles [rad] outside which the torque must be held for the model to be
            certified; None if it is certified for all angles.
        nrmse: sqrt(mean(w (Tc - Tm)^2)) / max|Tm| on the curves, with their weights w of mean 1.
        evaluations: how often the model was evaluated on all curves; a response with all its
            derivatives counts as three.
        history: (evaluations, best NRMSE) whenever the best one improved.
    """

    parameters: Array
    initial_torque: InitialTorque
    held: tuple[float, float] | None
    nrmse: float
    evaluations: int
    history: tuple[tuple[int, float], ...]

    @property
    def model(self) -> JilesAtherton | Held:
        """The certified model, held outside the fitted angles if it is safe inside only."""
        Ms, a, alpha, c, k = self.parameters.tolist()
        inner = JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
        return Held(model=inner, angle_range=self.held) if self.held else inner


def certified_fit(
    curves: Sequence[Curve],
    *,
    rng: int | np.random.Generator | None = None,
    budget: int = 200,
    initial_torque: InitialTorque = 0.0,
) -> CertifiedFit:
    """Fits a Jiles-Atherton model that no motion can drive into its pole.

    The parameters are searched as log a, the certificate's steepness alpha (2c-1) Ms / (3a),
    log(c-1), log(k(c-1)) and log Ms. What lacks a certificate, for all angles or at least for those
    of the curves, is penalized, and never returned. Sobol points of the first four are screened;
    Ms follows from a projection, because the torque of a motion that begins without torque is
    linear in Ms at fixed (a, alpha Ms, c, k). Bounded least squares with exact derivatives starts
    from the best ones in turn, until the residual is the measurement's own noise (estimated from
    second differences of the torque), or the budget is spent.

    Args:
        curves: the measured curves.
        rng: seed or generator of the Sobol scrambling.
        budget: most evaluations of the model on all curves.
        initial_torque: with which every curve begins [N·m]; "measured" takes each curve's first
            sample, "identified" searches one for all.

    Returns:
        The best parameters found, their NRMSE and how many evaluations they took.

    Raises:
        InputError: `budget` is too small, the curves are unusable, or nothing certified was found.
    """
    if budget <= SCREENED:
        raise InputError(f"budget is {budget}: use at least {SCREENED + 1} model evaluations")
    search = _Search(curves, initial_torque, budget)
    floor = noise_floor(curves) / search.objective.peak
    for start in search.screened(rng):
        try:
            search.minimize(start)
        except _BudgetSpent:
            break
        if search.score <= NOISE_MARGIN * floor:
            break
    return search.result()


def refined(
    curves: Sequence[Curve], row: Array, *, initial_torque: InitialTorque = 0.0, budget: int = 200
) -> CertifiedFit:
    """Does what `certified_fit` does, but from one start only, a row as `CurveObjective` takes."""
    search = _Search(curves, initial_torque, budget)
    try:
        search.minimize(search.coordinates(row))
    except _BudgetSpent:
        pass
    return search.result()


class _BudgetSpent(Exception):
    pass


class _Search:
    """Residuals over the search coordinates, with the best certified point kept.

    Coordinates are those of `search_box`, log Ms and, if it is identified, the initial torque over
    the peak. A row is Ms, a, alpha, c, k in degrees and, if it is identified, the initial torque.
    """

    def __init__(self, curves: Sequence[Curve], initial_torque: InitialTorque, budget: int) -> None:
        self.objective = CurveObjective(curves, initial_torque=initial_torque)
        self.budget = budget
        self.scale = np.sqrt(self.objective.weight) / self.objective.peak
        self.low_angle, self.high_angle = np.degrees(Curves(curves).angle_range).tolist()
        self.first_angles = np.degrees([curve.angle[0] for curve in curves])
        low, high = search_box(curves)
        others = [np.inf, 1.0][: 1 + (initial_torque == "identified")]
        self.low, self.high = np.append(low, np.negative(others)), np.append(high, others)
        self.best, self.score, self.evaluations = np.empty(0), np.inf, 0
        self.history: list[tuple[int, float]] = []

    def spend(self, evaluations: int) -> None:
        if self.evaluations + evaluations > self.budget:
            raise _BudgetSpent
        self.evaluations += evaluations

    def screened(self, rng: int | np.random.Generator | None) -> Array:
        """Returns starts, the best first, shape (SCREENED, coordinates)."""
        self.spend(SCREENED)
        from scipy.stats import qmc  # slow to import

        sobol = qmc.Sobol(4, rng=np.random.default_rng(rng)).random(SCREENED)
        points = self.low[:4] + sobol * (self.high - self.low)[:4]
        rows = unit_parameters(points)
        shape = CurveObjective(self.objective.curves).responses(rows) * self.scale
        torque = self.objective.torque * self.scale
        power = np.einsum("ij,ij->i", shape, shape)
        Ms = np.maximum(shape @ torque / power, LEAST_START * self.objective.peak)
        scores = np.sqrt(np.mean((Ms[:, None] * shape - torque) ** 2, axis=1))
        Ms = np.where(np.isfinite(Ms), Ms, self.objective.peak)
        rows[:, 0], rows[:, 2] = Ms, rows[:, 2] / Ms
        missing = np.array([self.missing_margin(row, np.zeros(1)) for row in rows])
        if self.objective.initial_torque == 0:
            for row, score, lacking in zip(rows, scores, missing, strict=True):
                self.keep(row, score, lacking)
        first = float(np.mean([curve.torque[0] for curve in self.objective.curves]))
        starts = np.column_stack(
            [points, np.log(Ms), np.full(SCREENED, first / self.objective.peak)]
        )
        costs = torque.size * scores**2 + (PENALTY * missing) ** 2
        return starts[np.argsort(costs), : self.low.size]  # NaN, past the pole, comes last

    def minimize(self, start: Array) -> None:
        """Runs bounded least squares from `start`."""
        least_squares(
            self.residual,
            start,
            jac=self.jacobian,  # type: ignore[arg-type]
            bounds=(self.low, self.high),
            x_scale="jac",
            ftol=STALLED,
            xtol=STALLED,
        )

    def residual(self, point: Array) -> Array:
        """Returns sqrt(w) (Tc - Tm) / max|Tm| and the penalty, shape (samples + 1,)."""
        self.spend(1)
        if point[4] < np.log(LEAST * self.objective.peak):  # as on curves that drive the joint
            return np.full(self.objective.torque.size + 1, REJECTED)
        (row,) = self.rows(point[None])
        error = (self.objective.responses(row)[0] - self.objective.torque) * self.scale
        error = np.where(np.isfinite(error), error, REJECTED)
        missing = self.missing_margin(row, self.objective.first_torques(row))
        self.keep(row, float(np.sqrt(np.mean(error**2))), missing)
        return np.append(error, PENALTY * missing)

    def keep(self, row: Array, score: float, missing: float) -> None:
        """Makes a row the best so far, if it is and is certified."""
        if missing <= MARGIN / 2 and score < self.score:
            self.best, self.score = row, score
            self.history.append((self.evaluations, score))

    def jacobian(self, point: Array) -> Array:
        """Returns the derivatives of `residual`, exact but for those of the penalty."""
        self.spend(DERIVATIVES_COST)
        (row,) = self.rows(point[None])
        by_row = self.objective.derivatives(row) * self.scale[:, None]
        # An infinitesimal imaginary step differentiates the coordinates exactly.
        by_coordinate = np.imag(self.rows(point + TINY * 1j * np.eye(point.size))).T / TINY
        by_point = np.where(np.isfinite(by_row), by_row, 0.0) @ by_coordinate
        moved = self.rows(point + DIFFERENCE * np.eye(point.size))
        first_torques = self.objective.first_torques
        missing = [self.missing_margin(one, first_torques(one)) for one in (row, *moved)]
        penalty = PENALTY * (np.array(missing[1:]) - missing[0]) / DIFFERENCE
        return np.vstack([by_point, penalty])

    def rows(self, points: NDArray[Any]) -> NDArray[Any]:
        unit, Ms = unit_parameters(points[:, :4]), np.exp(points[:, 4])
        return np.column_stack(
            [Ms, unit[:, 1], unit[:, 2] / Ms, unit[:, 3:], points[:, 5:] * self.objective.peak]
        )

    def coordinates(self, row: Array) -> Array:
        """Returns the point of a row, moved into the box."""
        Ms, a, alpha, c, k = row[:5].tolist()
        steepness = alpha * (2 * c - 1) * Ms / (3 * a)
        point = [np.log(a), steepness, np.log(c - 1), np.log(k * (c - 1)), np.log(Ms)]
        return np.clip([*point, *row[5:] / self.objective.peak], self.low, self.high)

    def missing_margin(self, row: Array, first: Array) -> float:
        """Returns what is missing to a certificate with MARGIN, at best in the range."""
        missing = self.shortfall(row, first, everywhere=True)
        return missing and min(missing, self.shortfall(row, first, everywhere=False))

    def shortfall(self, row: Array, first: Array, everywhere: bool) -> float:
        """Returns by how much the margin falls short; an unsafe start counts as MARGIN / 2."""
        Ms, a, alpha, c, k = row[:5].tolist()
        if everywhere:
            margin, bound = margin_everywhere(Ms, a, alpha, c, k)
        else:
            low, high = self.low_angle, self.high_angle
            margin, bound, _ = margin_in_range(low, high, Ms, a, alpha, c, k)
        lags = [
            abs(torque - Ms * langevin((angle + alpha * torque) / a)[0])
            for angle, torque in np.broadcast(self.first_angles, first)
            if torque  # the box keeps all starts without torque inside the bound
        ]
        excess = (max(lags, default=-np.inf) - bound) / Ms
        return min(max(MARGIN - margin, MARGIN / 2 + excess, 0.0), 1.0)

    def result(self) -> CertifiedFit:
        """Returns the best point.

        Raises:
            InputError: there is none.
        """
        if not np.isfinite(self.score):
            raise InputError(
                f"none of {self.evaluations} models tried on these curves is certified: raise the "
                "budget, or check the columns, the sign of the torque and the initial torque"
            )
        first = self.objective.first_torques(self.best)
        safe = self.shortfall(self.best, first, everywhere=True) <= MARGIN / 2
        measured = self.objective.initial_torque == "measured"
        return CertifiedFit(
            parameters=self.best[:5],
            initial_torque="measured" if measured else float(first[0]),
            held=None if safe else Curves(self.objective.curves).angle_range,
            nrmse=self.score,
            evaluations=self.evaluations,
            history=tuple(self.history),
        )


def search_box(curves: Sequence[Curve]) -> tuple[Array, Array]:
    """Returns the lower and upper bounds of log a, steepness, log(c-1) and log(k(c-1)), (4,)."""
    start = max(abs(float(np.degrees(curve.angle[0]))) for curve in curves)
    low = [np.log(SHAPE[0]), STEEPNESS[0], np.log(EXCESS[0]), np.log(max(start, 1.0))]
    high = [np.log(SHAPE[1]), STEEPNESS[1], np.log(EXCESS[1]), np.log(REACH_LIMIT)]
    return np.array(low), np.array(high)


def unit_parameters(coordinates: NDArray[Any]) -> NDArray[Any]:
    """Maps search coordinates (n, 4) to parameters (n, 5) with Ms = 1."""
    log_a, steepness, log_excess, log_reach = coordinates.T
    a, excess = np.exp(log_a), np.exp(log_excess)
    alpha = steepness * 3 * a / (2 * excess + 1)
    return np.stack([np.ones_like(a), a, alpha, 1 + excess, np.exp(log_reach) / excess], axis=1)
