"""Kernels of the motors' heat, element by element."""

# pyright: reportCallIssue=false, reportFunctionMemberAccess=false

import math

from numba import vectorize


@vectorize("f8(f8, f8, f8, f8)", cache=True)
def _heat(mean_square, torque, time_constant, dt):
    """Returns the running mean square of a torque after `dt`."""
    remains = math.exp(-dt / time_constant)
    return torque * torque + remains * (mean_square - torque * torque)


@vectorize("f8(f8, f8, f8, f8, f8)", cache=True)
def _clip(torque, mean_square, continuous, time_constant, dt):
    """Returns the torque, limited so that the mean square stays below the continuous one."""
    remains = math.exp(-dt / time_constant)
    allowed = (continuous * continuous - remains * mean_square) / (1 - remains)
    limit = math.sqrt(max(allowed, 0.0))
    return max(-limit, min(torque, limit))


# Called through NumPy: the call of numba's own object takes longer than the work.
heat = _heat.ufunc
clip = _clip.ufunc
