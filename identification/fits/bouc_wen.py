"""The Bouc-Wen model identified from first-order curves."""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...hysteresis.bouc_wen.model import BoucWen
from ..curves import Curve
from .projection import BesidePolynomial, search_shapes
from .search import Evaluation

# Search box.
YIELD = (0.003, 10.0)  # beta^(-1/n), the z where it yields, over the span of the angles
BEND = (-0.99, 1.0)  # gamma / beta; at least -1 and at most 1 is dissipative
SHARPNESS = (1.0, 20.0)  # n
SCREENED = 64


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
    search = search_shapes(_Shapes(beside), beside.floor, screened=SCREENED, budget=budget, rng=rng)
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


class _Shapes:
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
