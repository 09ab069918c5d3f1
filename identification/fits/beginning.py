"""The torque with which a fitted model begins the curves, and the Jiles-Atherton model inside."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.around import Clipped
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ...hysteresis.protocol import HysteresisModel
from ..curves import Curve, Curves
from ..prediction import torque_errors
from .search import REJECTED

BEGINNINGS = 1001  # number of torques tried in each direction, up to the peak of the curves


def common_torque(model: HysteresisModel, curves: Sequence[Curve]) -> float:
    """Returns the torque [N·m] with which a model that begins all curves fits them best.

    One measured sample would bring its whole noise into a prediction. Where the model's certificate
    does not cover that beginning, it is the nearest that is covered.
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
