"""The torque that a model predicts along measured curves, and its errors."""

from collections.abc import Sequence
from typing import cast

import numpy as np

from ..arrays import Array
from ..errors import InputError
from ..hysteresis.around import Viscoelastic
from ..hysteresis.certificate import PoleError
from ..hysteresis.protocol import HysteresisModel
from .curves import Curve, Curves
from .objective import InitialTorque


def torque_errors(
    model: HysteresisModel, initial_torque: InitialTorque, curves: Sequence[Curve]
) -> Array:
    """Returns Tc - Tm [N·m] along all curves, end to end; infinite on a curve with a pole."""
    return np.concatenate(
        [predicted(model, initial_torque, curve) - curve.torque for curve in curves]
    )


def predicted(model: HysteresisModel, initial_torque: InitialTorque, curve: Curve) -> Array:
    """Returns a model's torque along a curve [N·m]; infinite if it meets the pole there."""
    start = curve.torque[0] if initial_torque == "measured" else initial_torque
    try:
        if isinstance(model, Viscoelastic):
            return model.response(curve.angle, cast(float, start), times_of(curve))
        return model.response(curve.angle, cast(float, start))
    except PoleError:
        return np.full(curve.angle.size, np.inf)


def times_of(curve: Curve) -> Array:
    """Returns the times of a curve [s]."""
    if curve.time is None:
        raise InputError(
            f"curve {curve.name!r} has no times, and the model depends on the rate: add the column "
            "time_s, or leave rate out"
        )
    return curve.time


def nrmse(errors: Array, curves: Sequence[Curve]) -> float:
    """Returns the NRMSE: the root mean square of errors [N·m] over the curves' largest |Tm|."""
    return float(np.sqrt(np.mean(errors**2))) / Curves(curves).peak


def price(numbers: int, samples: int) -> float:
    """Returns the factor by which additional parameters must reduce the error of a model.

    That is the Bayesian information criterion for independent noise (Schwarz 1978).

    Args:
        numbers: Number of additional parameters.
        samples: Number of samples that the model is fitted to.
    """
    return float(samples ** (numbers / (2 * samples)))
