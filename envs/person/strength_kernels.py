"""Kernels of the strength of muscle groups, for any number of wearers at once."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportFunctionMemberAccess=false

import math

from numba import guvectorize, njit


@njit(cache=True)
def velocity_factor(shortening: float, hill: float, gain: float, knee: float) -> float:
    """Returns torque / isometric torque at a shortening speed, given over the fastest speed.

    Hill's hyperbola through (0, 1), (1/2, half_speed) and (1, 0), and for lengthening another one
    that leaves (0, 1) with the same slope and meets (-1, eccentric); constant beyond both ends.
    """
    if shortening >= 0.0:
        shorter = min(shortening, 1.0)
        return (1.0 - shorter) / (1.0 + shorter / hill)
    longer = min(-shortening, 1.0)
    return 1.0 + gain * (1.0 + knee) * longer / (longer + knee)


@njit(cache=True)
def group_torque(
    isometric: float,
    angle: float,
    speed: float,
    fastest: float,
    best_angle: float,
    width: float,
    hill: float,
    gain: float,
    knee: float,
) -> float:
    """Returns the greatest torque of a muscle group that shortens at `speed` [rad/s]."""
    offset = (angle - best_angle) / width
    strength = isometric * math.exp(-offset * offset / 2.0)
    return strength * velocity_factor(speed / fastest, hill, gain, knee)


@guvectorize(
    "void(f8[:,:], f8[:], f8[:], f8[:,:,:], f8[:], f8[:])",
    "(g,j),(j),(j),(c,g,j)->(j),(j)",
    cache=True,
)
def _limits(isometric, angle, rate, groups, low, high):
    """Computes the least and the greatest torque at every joint, in place.

    `groups` contains these values in turn: fastest speed, best angle, width, and the three shape
    parameters of `velocity_factor`.
    """
    for joint in range(angle.shape[0]):
        for way in range(2):
            fastest, best_angle, width, hill, gain, knee = groups[:, way, joint]
            torque = group_torque(
                isometric[way, joint],
                angle[joint],
                rate[joint] if way == 1 else -rate[joint],
                fastest,
                best_angle,
                width,
                hill,
                gain,
                knee,
            )
            if way == 1:
                high[joint] = torque
            else:
                low[joint] = -torque


# Called through NumPy, since a call of numba's own object takes longer than the computation.
limits = _limits.ufunc
