"""Models without memory, which a hysteresis model has to outperform."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array
from ..hysteresis.branches import Branches, spring, spring_with_friction, two_branches
from .curves import Curve
from .left_out import Question
from .prediction import nrmse

BASELINES: dict[str, Callable[[Array, Array], Branches]] = {
    "a spring": spring,
    "a spring with friction": spring_with_friction,
    "two branches without memory": two_branches,
}


def baseline_errors(curves: Sequence[Curve]) -> dict[str, float]:
    """Returns the NRMSE of models without memory on the curves that they are fitted to."""
    whole = [Question(list(curves), curve, slice(None)) for curve in curves]
    return predictions(whole, curves)


def predictions(asked: Sequence[Question], curves: Sequence[Curve]) -> dict[str, float]:
    """Returns the NRMSE with which models without memory predict data left out of their fit.

    Args:
        asked: Parts that are left out, each with the curves that are fitted instead.
        curves: All curves, whose largest torque divides the errors.
    """
    found = {}
    for name, fit in BASELINES.items():
        errors = []
        for question in asked:
            angle = np.concatenate([curve.angle for curve in question.known])
            torque = np.concatenate([curve.torque for curve in question.known])
            if fit is two_branches and not 1 <= np.sum(np.diff(angle) < 0) < angle.size - 1:
                break  # motions of one direction have no second branch
            model = fit(angle, torque)
            errors.append(question.errors(model.response(question.curve.angle)))
        else:
            found[name] = nrmse(np.concatenate(errors), curves)
    return found
