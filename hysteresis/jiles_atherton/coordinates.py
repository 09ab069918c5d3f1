"""Coordinates in which every Jiles-Atherton model is certified, and the nearest certified model.

A point is

    log a,  alpha (2c-1) Ms / (3a),  log(c-1),  log(k (c-1)),  log Ms.

The second is the certificate's steepness: where it is between -2 and 1, no motion meets the pole at
any angle. A row is Ms, a, alpha, c, k. All angles are in one unit. The first four coordinates
describe the shape of the loops alone: where they are fixed, the torque is proportional to Ms.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import InputError
from ..certificate import PoleError
from .model import PARAMETERS, JilesAtherton

LOG_A, STEEPNESS, LOG_EXCESS, LOG_REACH, LOG_MS = range(5)
STEEPNESS_LIMITS = (-2.0, 1.0)  # every model with c > 1 between them is certified at all angles
MARGIN = 0.02  # certificate margin that the result keeps
LEAST_EXCESS = 0.01  # least c - 1 of the result
REACH = 5.0  # [e-folds], range of the search to either side
C = PARAMETERS.index("c")
WIDEST = 100.0  # first range of the search for common angles, in units of a or k
SAMPLES = 60  # number of samples per branch
TIE_BREAK = 1e-3  # share of the curve's peak per e-fold of an undetermined parameter


def unit_rows(shapes: NDArray[Any]) -> NDArray[Any]:
    """Returns the rows, with Ms = 1, of points without the last coordinate, (n, 4) -> (n, 5)."""
    log_a, steepness, log_excess, log_reach = shapes.T
    a, excess = np.exp(log_a), np.exp(log_excess)
    made = np.empty((len(a), 5), a.dtype)  # a third of the time that np.stack takes
    made[:, 0], made[:, 1], made[:, 2] = 1, a, steepness * 3 * a / (2 * excess + 1)
    made[:, 3], made[:, 4] = 1 + excess, np.exp(log_reach) / excess
    return made


def rows(points: NDArray[Any]) -> NDArray[Any]:
    """Returns the rows of points, (n, 5) -> (n, 5); complex points give complex rows."""
    made, Ms = unit_rows(points[:, :LOG_MS]), np.exp(points[:, LOG_MS])
    made[:, 0] = Ms
    made[:, 2] /= Ms
    return made


def point(row: Array) -> Array:
    """Returns the point of a row with c > 1, (5,) -> (5,)."""
    Ms, a, alpha, c, k = row.tolist()
    steepness = alpha * (2 * c - 1) * Ms / (3 * a)
    return np.array([np.log(a), steepness, np.log(c - 1), np.log(k * (c - 1)), np.log(Ms)])


class Nearest(NamedTuple):
    """A certified model near another model.

    Attributes:
        model: Certified model.
        change: Root mean square difference of both models' curves, as a share of their peak.
    """

    model: JilesAtherton
    change: float


def nearest_certified(model: JilesAtherton) -> Nearest:
    """Finds the certified model with the least mean square change of torque.

    The compared curves are a first loading, a full loop and a half loop between -R and R. R is the
    largest angle up to which the given model is safe, by the certificate for that range, so that
    its curves exist. The search runs in coordinates in which every point is certified.

    Args:
        model: Any Jiles-Atherton model; a certified model comes back as it is. The nearest model
            has form `bulk` without a clamp, also for another form or clamp.

    Returns:
        A certified model in the same angle unit, and the difference of the curves.
    """
    from scipy.optimize import least_squares  # slow to import, rarely needed

    if not isinstance(model, JilesAtherton):
        raise InputError(f"model is a {type(model).__name__}: give a JilesAtherton model")
    certificate = model.certificate()
    if certificate.certified and certificate.dissipative:
        return Nearest(model, 0.0)
    reach = _safe_reach(_plain(model))
    up = np.linspace(-reach, reach, 2 * SAMPLES)
    half = np.linspace(reach, 0, SAMPLES)
    angle = np.concatenate([np.linspace(0, reach, SAMPLES), up[::-1], up, half, half[::-1]])
    wanted = _torque(model, angle)
    scale = np.abs(wanted).max()

    def residual(point: Array) -> Array:
        change = (_torque(_at(point, model), angle) - wanted) / (scale * np.sqrt(angle.size))
        moved = point - start
        moved[LOG_REACH] = (point[LOG_REACH] - point[LOG_EXCESS]) - log_k
        return np.concatenate([change, TIE_BREAK * moved])

    start, low, high = _box(model)
    log_k = start[LOG_REACH] - start[LOG_EXCESS]
    fit = least_squares(residual, start, bounds=(low, high), x_scale="jac", max_nfev=100)
    return Nearest(_at(fit.x, model), float(np.linalg.norm(fit.fun[: angle.size])))


def _box(model: JilesAtherton) -> tuple[Array, Array, Array]:
    """Returns where the search begins, and its bounds."""
    row = np.array([getattr(model, name) for name in PARAMETERS])
    steepness = model.alpha * (2 * model.c - 1) * model.Ms / (3 * model.a)
    row[C] = max(model.c, 1 + LEAST_EXCESS)
    start = point(row)
    low, high = start - REACH, start + REACH
    least, most = STEEPNESS_LIMITS
    low[STEEPNESS], high[STEEPNESS] = least + MARGIN, most - MARGIN
    start[STEEPNESS] = np.clip(steepness, least + 2 * MARGIN, most - 2 * MARGIN)
    low[LOG_EXCESS] = np.log(LEAST_EXCESS) - 1e-9
    return start, low, high


def _at(point: Array, model: JilesAtherton) -> JilesAtherton:
    (row,) = rows(point[None]).tolist()
    parameters = dict(zip(PARAMETERS, row, strict=True))
    return replace(_plain(model), **parameters, allow_active=False)


def _plain(model: JilesAtherton) -> JilesAtherton:
    """Returns the model in form `bulk` without a clamp, which alone has a certificate."""
    return replace(model, form="bulk", clamp="none", allow_active=True)


def _safe_reach(model: JilesAtherton) -> float:
    """Returns an angle [rad] up to which no motion from rest meets the pole."""
    _, a, _, _, k = model.parameter_vector[:5]
    unsafe, reach = np.inf, WIDEST * max(a, k)
    for _ in range(60):
        if model.certificate((-reach, reach)).margin > MARGIN:
            if unsafe - reach < 0.05 * reach or unsafe == np.inf:
                break
            reach = 0.5 * (reach + unsafe)
        else:
            unsafe, reach = reach, 0.5 * reach
    return float(reach)


def _torque(model: JilesAtherton, angle: Array) -> Array:
    try:
        return model.response(angle)
    except PoleError:  # even the smallest range is unsafe: compare with the anhysteretic curve
        soft = replace(_plain(model), alpha=0.0, c=max(model.c, 1.0))
        return soft.response(angle)
