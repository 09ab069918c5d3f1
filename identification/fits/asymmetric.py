"""The Jiles-Atherton model beside an elastic polynomial, identified from first-order curves."""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.around import Asymmetric, Clipped
from ...hysteresis.jiles_atherton import coordinates, kernels
from ...hysteresis.jiles_atherton.langevin import langevin
from ...hysteresis.jiles_atherton.margins import margin_everywhere, margin_in_range
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ...hysteresis.polynomial import LARGEST_DEGREE
from ..curves import Curve
from .certified import shape_box
from .projection import BesidePolynomial, search_shapes
from .search import MARGIN, Evaluation

SCREENED = 64
BUDGET = 600  # evaluations of the model on all curves


def fit_asymmetric(
    curves: Sequence[Curve], rng: int | np.random.Generator | None = None, degree: int = 3
) -> Asymmetric:
    """Fits a certified Jiles-Atherton model and an elastic polynomial together.

    The Jiles-Atherton part begins with some torque M0 of its own, the polynomial gives the rest of
    the curves' first torque. At fixed (a, alpha Ms, c, k, M0 / Ms) the whole torque is linear in Ms
    and the polynomial, which follow from a projection with Ms > 0: exact, since M0 scales with Ms.
    The five are searched as in `certified_fit`, and M0 over the certificate's memory bound. A model
    or a beginning without a certificate, for all angles or at least for those of the curves, is
    penalized, and never returned.

    Args:
        curves: First-order curves, which all begin at one angle and with one torque, zero or not;
            those with role "fit" are used.
        rng: Seed or generator of the Sobol scrambling.
        degree: Degree of the polynomial, 1 to 5.

    Returns:
        The model; its Jiles-Atherton part has a constant torque outside the angles of the curves if
        it is safe inside only. `response(angle, initial_torque)` predicts a curve.
    """
    if not 1 <= degree <= LARGEST_DEGREE:
        raise InputError(f"degree is {degree}: use 1 to {LARGEST_DEGREE}")
    beside = BesidePolynomial(curves, degree)
    unit = _UnitModels(beside)
    search = search_shapes(unit, beside.floor, screened=SCREENED, budget=BUDGET, rng=rng)
    if search.best is None:
        raise InputError(
            f"none of {search.evaluations} models tried on these curves is certified: check the "
            "columns and the sign of the torque"
        )
    shape = unit.response(search.best)
    (_, a, alpha, c, k), _ = _unit(search.best)
    Ms = beside.scale(shape)
    inner = JilesAtherton(Ms=Ms, a=a, alpha=alpha / Ms, c=c, k=k, angle_unit="deg")
    safe = unit.excess(search.best, everywhere=True) <= MARGIN / 2
    return Asymmetric(
        model=inner if safe else Clipped(model=inner, angle_range=(beside.low, beside.high)),
        polynomial=beside.polynomial(shape),
    )


def _unit(point: Array) -> tuple[tuple[float, ...], float]:
    """Returns 1, a, alpha, c, k in degrees, and the torque at the beginning, all for Ms = 1."""
    (row,) = coordinates.unit_rows(point[None, :4])
    bound = float(np.exp(point[3])) / (3 * row[1])  # k (c - 1) / (3a), the certificate's
    return tuple(row.tolist()), float(point[4]) * bound


class _UnitModels:
    """The errors of models with Ms = 1 beside the best polynomial."""

    def __init__(self, beside: BesidePolynomial) -> None:
        self.beside, self.starts = beside, beside.starts
        self.degrees, self.start = np.degrees(beside.angle), float(np.degrees(beside.start))
        self.range = np.degrees(beside.low), np.degrees(beside.high)
        low, high = shape_box(beside.curves)
        self.low, self.high = np.append(low, -1.0), np.append(high, 1.0)

    def evaluate(self, point: Array) -> Evaluation:
        """Returns the errors of a point, with the projection done, and its missing margin."""
        errors = self.beside.residual(self.response(point))
        return Evaluation(errors, self.missing_margin(point), point.copy())

    def response(self, point: Array) -> Array:
        """Returns the torque along all curves, shape (samples,)."""
        row, first = _unit(point)
        torque = np.empty((1, self.degrees.size))
        initial = np.full((1, self.starts.size - 1), first)
        kernels.population_response(self.degrees, self.starts, initial, np.array([row]), torque)
        return torque[0]

    def missing_margin(self, point: Array) -> float:
        """Returns what is missing to a certificate, at best in the range of the curves."""
        missing = self.excess(point, everywhere=True)
        return missing if missing == 0 else min(missing, self.excess(point, everywhere=False))

    def excess(self, point: Array, everywhere: bool) -> float:
        """Returns by how much the margin falls short, or the lag of the beginning exceeds."""
        row, first = _unit(point)
        if everywhere:
            margin, bound = margin_everywhere(*row)
        else:
            margin, bound, _ = margin_in_range(*self.range, *row)
        _, a, alpha, _, _ = row
        lag = abs(first - langevin((self.start + alpha * first) / a)[0])
        # What lacks MARGIN / 2 still passes, but the lag must not exceed its bound at all.
        return min(max(MARGIN - margin, lag - bound + MARGIN / 2, 0.0), 1.0)
