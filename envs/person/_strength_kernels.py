"""Kernels of the strength of muscle groups, for any number of wearers at once."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportFunctionMemberAccess=false

import math

from numba import guvectorize, njit


@njit(cache=True)
def velocity_factor(shortening, hill, gain, knee):
    """Returns torque / isometric torque at a shortening speed, given over the fastest speed.

    Hill's hyperbola through (0, 1), (1/2, half_speed) and (1, 0), and for lengthening another one
    that leaves (0, 1) with the same slope and meets (-1, eccentric); constant beyond both ends.
    """
    if shortening >= 0:
        shorter = min(shortening, 1.0)
        return (1 - shorter) / (1 + shorter / hill)
    longer = min(-shortening, 1.0)
    return 1 + gain * (1 + knee) * longer / (longer + knee)


@guvectorize(
    "void(f8[:,:], f8[:], f8[:], f8[:,:,:], f8[:], f8[:])",
    "(g,j),(j),(j),(c,g,j)->(j),(j)",
    cache=True,
)
def _limits(isometric, angle, rate, groups, low, high):
    """Computes the least and the greatest torque at every joint, in place.

    `groups` holds these values in turn: fastest speed, best angle, width, and the three shape
    parameters of `velocity_factor`.
    """
    for joint in range(angle.shape[0]):
        for way in range(2):
            fastest, best_angle, width, hill, gain, knee = groups[:, way, joint]
            offset = (angle[joint] - best_angle) / width
            strength = isometric[way, joint] * math.exp(-offset * offset / 2)
            speed = rate[joint] / fastest
            if way == 0:
                low[joint] = -strength * velocity_factor(-speed, hill, gain, knee)
            else:
                high[joint] = strength * velocity_factor(speed, hill, gain, knee)


# Called through NumPy: the call of numba's own object takes longer than the work.
limits = _limits.ufunc
