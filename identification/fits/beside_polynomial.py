"""Models beside an elastic polynomial: Jiles-Atherton, Bouc-Wen, Dahl and Duhem.

The fits take the curves with role "fit", which all begin at one angle and with one torque, zero or
not; the seed or generator of the Sobol scrambling; the degree of the polynomial, 1 to 5; and the
largest number of evaluations of the model on all curves. `response(angle, initial_torque)` of the
returned model predicts a curve.
"""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ...hysteresis.around import Asymmetric, Clipped
from ...hysteresis.bouc_wen.model import BoucWen
from ...hysteresis.dahl.model import Dahl, Duhem
from ...hysteresis.jiles_atherton import coordinates, kernels
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ...hysteresis.polynomial import LARGEST_DEGREE
from ..data.curves import Curve
from .certified import missing_margin, shape_box, shortfall
from .search import MARGIN, BesidePolynomial, search_shapes

SCREENED = 64
BUDGET = 600  # evaluations of the model on all curves
# Search box.
YIELD = (0.003, 10.0)  # beta^(-1/n), the z of yielding, over the span of the angles
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
    penalized, and never returned. If the Jiles-Atherton part is safe inside the angles of the
    curves only, its torque is constant outside.
    """
    if not 1 <= degree <= LARGEST_DEGREE:
        raise InputError(f"degree is {degree}: use 1 to {LARGEST_DEGREE}")
    beside = BesidePolynomial(curves, degree)
    degrees, start = np.degrees(beside.angle), np.degrees([beside.start])
    inside = float(np.degrees(beside.low)), float(np.degrees(beside.high))
    low, high = shape_box(beside.curves)

    def torque(point: Array) -> Array:
        row, first = _unit(point)
        found = np.empty((1, degrees.size))
        initial = np.full((1, beside.starts.size - 1), first)
        kernels.population_response(degrees, beside.starts, initial, row[None], found)
        return found[0]

    box = np.append(low, -1.0), np.append(high, 1.0)

    def lacking(point: Array) -> float:
        return missing_margin(*_unit(point), start, inside)

    search = search_shapes(beside, box, torque, lacking, screened=SCREENED, budget=BUDGET, rng=rng)
    if search.best is None:
        raise InputError(
            f"none of {search.evaluations} models tried on these curves is certified: check the "
            "columns and the sign of the torque"
        )
    row, first = _unit(search.best)
    _, a, alpha, c, k = row.tolist()
    shape = torque(search.best)
    Ms = beside.scale(shape)
    inner = JilesAtherton(Ms=Ms, a=a, alpha=alpha / Ms, c=c, k=k, angle_unit="deg")
    safe = shortfall(row, first, start) <= MARGIN / 2
    return Asymmetric(
        model=inner if safe else Clipped(model=inner, angle_range=(beside.low, beside.high)),
        polynomial=beside.polynomial(shape),
    )


def _unit(point: Array) -> tuple[Array, float]:
    """Returns 1, a, alpha, c, k in degrees, and the torque at the beginning, all for Ms = 1."""
    (row,) = coordinates.unit_rows(point[None, :4])
    bound = float(np.exp(point[3])) / (3 * row[1])  # k (c - 1) / (3a), the certificate's
    return row, float(point[4]) * bound


def fit_bouc_wen(
    curves: Sequence[Curve], rng: int | np.random.Generator | None = None, budget: int = 400
) -> BoucWen:
    """Fits a dissipative Bouc-Wen model with A = 1 by variable projection.

    At fixed (beta, gamma, n) and z at the beginning, torque is linear in the elastic and the
    hysteretic stiffness and in the elastic torque at the beginning, for which the rest angle
    stands for. Those three follow from a projection, with hysteretic > 0. The others are searched
    as log beta^(-1/n), gamma / beta, log n and z over its bound: bounded least squares from the
    best of some Sobol points, in a box whose models are all certified and dissipative.
    """
    beside = BesidePolynomial(curves, degree=1)
    span = beside.high - beside.low
    ends = zip(YIELD, BEND, SHARPNESS, (-1.0, 1.0), strict=True)
    box = [(np.log(one * span), bend, np.log(n), start) for one, bend, n, start in ends]

    def shape(point: Array) -> Array:
        return _memory(point, beside.curves)

    search = search_shapes(beside, box, shape, screened=SCREENED, budget=budget, rng=rng)
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
    """
    spring, stiffness, (friction,) = _fit(curves, 1, rng, degree, budget)
    return Dahl(spring=spring, stiffness=stiffness, friction=friction)


def fit_duhem(
    curves: Sequence[Curve],
    rng: int | np.random.Generator | None = None,
    degree: int = 3,
    budget: int = 400,
) -> Duhem:
    """Fits a friction whose ways up and down are unlike, as `fit_dahl` with two yield angles."""
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

    def limits(point: Array) -> Array:
        """Returns z for a stiffness of 1, from its upper and its lower limit, (samples, 2)."""
        up, *_, down = 2 * np.exp(point).tolist()
        model = Duhem(spring=(0.0,), stiffness=1.0, friction_up=up, friction_down=down)
        columns = [[model.response(one.angle, z) for one in beside.curves] for z in (up, -down)]
        return np.stack([np.concatenate(column) for column in columns], axis=1)

    def shape(point: Array) -> Array:
        from_limits = limits(point)
        return from_limits @ beside.weights(from_limits)

    box = np.log(np.outer(YIELD, np.full(ways, beside.high - beside.low)))
    search = search_shapes(beside, box, shape, screened=FEW_SCREENED, budget=budget, rng=rng)
    assert search.best is not None  # all points are allowed
    stiffness = float(beside.weights(limits(search.best)).sum())
    frictions = stiffness * np.exp(search.best)
    return beside.polynomial(shape(search.best)), stiffness, frictions.tolist()
