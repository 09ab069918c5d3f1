"""Kernels of the motors' heat."""

import math

from numba import njit


@njit(cache=True)
def heated(mean_square: float, torque: float, time_constant: float, dt: float) -> float:
    """Returns the running mean square of a torque after `dt`."""
    remains = math.exp(-dt / time_constant)
    return torque * torque + remains * (mean_square - torque * torque)


@njit(cache=True)
def clipped(
    torque: float, mean_square: float, continuous: float, time_constant: float, dt: float
) -> float:
    """Returns the torque, limited so that the mean square stays below the continuous one."""
    remains = math.exp(-dt / time_constant)
    allowed = (continuous * continuous - remains * mean_square) / (1.0 - remains)
    limit = math.sqrt(max(allowed, 0.0))
    return max(-limit, min(torque, limit))
