"""Models beside an elastic polynomial: Jiles-Atherton, Bouc-Wen, Dahl and Duhem."""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ...hysteresis.around.asymmetric import Asymmetric
from ...hysteresis.around.clipped import Clipped
from ...hysteresis.bouc_wen.model import BoucWen
from ...hysteresis.dahl.model import Dahl, Duhem
from ...hysteresis.jiles_atherton import coordinates, kernels
from ...hysteresis.jiles_atherton.langevin import langevin
from ...hysteresis.jiles_atherton.margins import margin_everywhere, margin_in_range
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ...hysteresis.polynomial import LARGEST_DEGREE
from ..data.curves import Curve
from .certified import shape_box
from .search import MARGIN, BesidePolynomial, Evaluation, search_shapes

SCREENED = 64
BUDGET = 600  # evaluations of the model on all curves
# Search box.
YIELD = (0.003, 10.0)  # beta^(-1/n), the z where it yields, over the span of the angles
BEND = (-0.99, 1.0)  # gamma / beta; at least -1 and at most 1 is dissipative
SHARPNESS = (1.0, 20.0)  # n
FEW_SCREENED = 8


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


def fit_bouc_wen(
    curves: Sequence[Curve], rng: int | np.random.Generator | None = None, budget: int = 400
) -> BoucWen:
    """Fits a dissipative Bouc-Wen model with A = 1 by variable projection.

    At fixed (beta, gamma, n) and z at the beginning, torque is linear in the elastic and the
    hysteretic stiffness and in the elastic torque at the beginning, which is what the rest angle
    stands for. Those three follow from a projection, with hysteretic > 0. The others are searched
    as log beta^(-1/n), gamma / beta, log n and z over its bound: bounded least squares from the
    best of some Sobol points, in a box whose models are all certified and dissipative.

    Args:
        curves: First-order curves, which all begin at one angle and with one torque, zero or not;
            those with role "fit" are used.
        rng: Seed or generator of the Sobol scrambling.
        budget: Largest number of evaluations of the model on all curves.

    Returns:
        The model; `response(angle, initial_torque)` predicts a curve.
    """
    beside = BesidePolynomial(curves, degree=1)
    search = search_shapes(
        _Memories(beside), beside.floor, screened=SCREENED, budget=budget, rng=rng
    )
    assert search.best is not None  # all points are allowed
    z = _memory(search.best, beside.curves)
    offset, elastic = beside.polynomial(z)
    beta, gamma, n, _ = _parameters(search.best)
    return BoucWen(
        elastic=elastic,
        hysteretic=beside.scale(z),
        beta=beta,
        gamma=gamma,
        n=n,
        rest_angle=-offset / elastic if elastic else beside.start,
    )


class _Memories:
    """The errors of Bouc-Wen memories, with the projection done."""

    def __init__(self, beside: BesidePolynomial) -> None:
        span = beside.high - beside.low
        self.beside = beside
        self.low = np.array([np.log(YIELD[0] * span), BEND[0], np.log(SHARPNESS[0]), -1.0])
        self.high = np.array([np.log(YIELD[1] * span), BEND[1], np.log(SHARPNESS[1]), 1.0])

    def evaluate(self, point: Array) -> Evaluation:
        """Returns the errors of a point; every one in the box is certified."""
        errors = self.beside.residual(_memory(point, self.beside.curves))
        return Evaluation(errors, 0.0, point.copy())


def _parameters(point: Array) -> tuple[float, float, float, float]:
    """Returns beta, gamma, n and z at the beginning over its bound."""
    log_yield, bend, log_n, start = point.tolist()
    n = float(np.exp(log_n))
    beta = float(np.exp(-n * log_yield))
    return beta, bend * beta, n, start


def _memory(point: Array, curves: Sequence[Curve]) -> Array:
    """Returns z [rad] along all curves, shape (samples,)."""
    beta, gamma, n, start = _parameters(point)
    model = BoucWen(elastic=0.0, hysteretic=1.0, beta=beta, gamma=gamma, n=n)
    z = start * model.z_bound
    return np.concatenate([model.response(curve.angle, z) for curve in curves])


def fit_dahl(
    curves: Sequence[Curve],
    rng: int | np.random.Generator | None = None,
    degree: int = 3,
    budget: int = 200,
) -> Dahl:
    """Fits Dahl's friction beside a polynomial spring by variable projection.

    At a fixed yield angle, friction / stiffness, torque is linear in the stiffness, in z at the
    beginning and in the spring. z is linear in its beginning too, so that the motions which begin
    at its two limits, each with a weight of at least 0, give all beginnings in between: weights and
    spring follow from non-negative least squares. The logarithm of the yield angle is searched,
    from the best of some Sobol points. Every such model is certified and dissipative.

    Args:
        curves: First-order curves, which all begin at one angle and with one torque, zero or not;
            those with role "fit" are used.
        rng: Seed or generator of the Sobol scrambling.
        degree: Degree of the spring, 1 to 5.
        budget: Largest number of evaluations of the model on all curves.

    Returns:
        The model; `response(angle, initial_torque)` predicts a curve.
    """
    spring, stiffness, (friction,) = _fit(curves, 1, rng, degree, budget)
    return Dahl(spring=spring, stiffness=stiffness, friction=friction)


def fit_duhem(
    curves: Sequence[Curve],
    rng: int | np.random.Generator | None = None,
    degree: int = 3,
    budget: int = 400,
) -> Duhem:
    """Fits a friction whose ways up and down are unlike, as `fit_dahl` with two yield angles.

    Args:
        curves: First-order curves, as `fit_dahl` takes them.
        rng: Seed or generator of the Sobol scrambling.
        degree: Degree of the spring, 1 to 5.
        budget: Largest number of evaluations of the model on all curves.

    Returns:
        The model; `response(angle, initial_torque)` predicts a curve.
    """
    spring, stiffness, (up, down) = _fit(curves, 2, rng, degree, budget)
    return Duhem(spring=spring, stiffness=stiffness, friction_up=up, friction_down=down)


def _fit(
    curves: Sequence[Curve],
    ways: int,
    rng: int | np.random.Generator | None,
    degree: int,
    budget: int,
) -> tuple[list[float], float, list[float]]:
    """Returns the spring, the stiffness, and one friction or one for each way."""
    at_least("degree", degree, 1, LARGEST_DEGREE)
    beside = BesidePolynomial(curves, degree)
    shapes = _YieldAngles(beside, ways)
    search = search_shapes(shapes, beside.floor, screened=FEW_SCREENED, budget=budget, rng=rng)
    assert search.best is not None  # all points are allowed
    limits = shapes.from_limits(search.best)
    weights = beside.weights(limits)
    stiffness = float(weights.sum())
    frictions = stiffness * np.exp(search.best)
    return beside.polynomial(limits @ weights), stiffness, frictions.tolist()


class _YieldAngles:
    """The errors of yield angles, one or one for each way, with the projection done."""

    def __init__(self, beside: BesidePolynomial, ways: int) -> None:
        self.beside = beside
        self.low, self.high = np.log(np.outer(YIELD, np.full(ways, beside.high - beside.low)))

    def evaluate(self, point: Array) -> Evaluation:
        """Returns the errors of a point; every one is certified."""
        limits = self.from_limits(point)
        errors = self.beside.residual(limits @ self.beside.weights(limits))
        return Evaluation(errors, 0.0, point.copy())

    def from_limits(self, point: Array) -> Array:
        """Returns z for a stiffness of 1, from its upper and its lower limit, (samples, 2)."""
        up, *_, down = 2 * np.exp(point).tolist()
        model = Duhem(spring=(0.0,), stiffness=1.0, friction_up=up, friction_down=down)
        curves = self.beside.curves
        columns = [[model.response(one.angle, z) for one in curves] for z in (up, -down)]
        return np.stack([np.concatenate(column) for column in columns], axis=1)
