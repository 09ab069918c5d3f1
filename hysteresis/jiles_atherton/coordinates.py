"""Coordinates of the Jiles-Atherton model in which every point of a box is certified.

A point is

    log a,  alpha (2c-1) Ms / (3a),  log(c-1),  log(k (c-1)),  log Ms.

The second is the certificate's steepness: where it is between -2 and 1, no motion meets the pole at
any angle. A row is Ms, a, alpha, c, k. All angles are in one unit. The first four coordinates
describe the shape of the loops alone: where they are fixed, the torque is proportional to Ms.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array

LOG_A, STEEPNESS, LOG_EXCESS, LOG_REACH, LOG_MS = range(5)
STEEPNESS_LIMITS = (-2.0, 1.0)  # every model with c > 1 between them is certified at all angles


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
