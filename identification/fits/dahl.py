"""Dahl's friction and the semilinear Duhem model identified from first-order curves."""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...checks import at_least
from ...hysteresis.dahl.model import Dahl, Duhem
from ...hysteresis.polynomial import LARGEST_DEGREE
from ..curves import Curve
from .projection import BesidePolynomial, search_shapes
from .search import Evaluation

YIELD = (0.003, 10.0)  # search box: friction / stiffness over the span of the angles
SCREENED = 8


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
    shapes = _Shapes(beside, ways)
    search = search_shapes(shapes, beside.floor, screened=SCREENED, budget=budget, rng=rng)
    assert search.best is not None  # all points are allowed
    limits = shapes.from_limits(search.best)
    weights = beside.weights(limits)
    stiffness = float(weights.sum())
    frictions = stiffness * np.exp(search.best)
    return beside.polynomial(limits @ weights), stiffness, frictions.tolist()


class _Shapes:
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
