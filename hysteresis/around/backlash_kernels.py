"""Contact across a gap, which `Backlash` and the engine share.

The model behind the gap has kernels, a memory s, parameters p, the coefficients of an elastic
`polynomial`, and `limits`, the range outside which the torque is constant; both may be empty. The
array `play` holds the gap [rad] and the angle of the suit's side [rad].
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from collections.abc import Callable
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np
from numba import njit

from ..polynomial import value_of
from ..protocol import stamp_of

GAP, END, SIZE = range(3)
ZERO = 1e-9  # N·m, largest torque that counts as none
OPEN = ZERO / 10  # torque at the root where contact opens, so small that it counts as none
TRIALS = 100  # most iterations for that root; 5 to 10 are usual


@njit
def is_sound(play):
    """Returns whether the numbers, which a user can overwrite, are a gap and an angle."""
    return math.isfinite(play[GAP]) and play[GAP] > 0 and math.isfinite(play[END])


@njit
def within(limits, angle):
    """Returns the angle, clipped to `limits` unless these are empty."""
    if limits.size == 0 or math.isnan(angle):
        return angle
    return min(max(angle, limits[0]), limits[1])


@njit(cache=True)
def begun(gap, angle, torque):
    """Returns the angle of the suit's side at the start, which is in contact if torque is not 0."""
    if abs(torque) <= ZERO:
        return angle
    return angle - math.copysign(gap / 2, torque)


@njit(inline="always")
def torque_at(kernels, p, s, polynomial, limits, end):
    """Returns the torque after a monotone motion of the suit's side; s unchanged."""
    inside, torque = within(limits, end), s[1]
    if inside != s[0]:
        torque = kernels.move(p, s, inside)[0]
    return torque + value_of(polynomial, end)


@njit(inline="always")
def opening(kernels, p, s, polynomial, limits, near, torque, far):
    """Returns the angle between `near` and `far` at which the torque vanishes, or `far`.

    The search brackets the root by the Illinois rule (Dowell and Jarratt 1971).
    """
    last = torque_at(kernels, p, s, polynomial, limits, far)
    if not last * torque < 0:
        return far
    for _ in range(TRIALS):
        middle = far - last * (far - near) / (last - torque)
        if not min(near, far) < middle < max(near, far):
            middle = (near + far) / 2
        if middle in (near, far):
            break
        now = torque_at(kernels, p, s, polynomial, limits, middle)
        if now * last < 0:
            near, torque = far, last
        else:
            torque /= 2
        far, last = middle, now
        if abs(last) <= OPEN:
            break
    return far


@njit(cache=True)
def end_at(kernels, p, s, polynomial, limits, play, angle):
    """Returns the angle of the suit's side after a monotone motion of the joint to `angle`.

    The function changes no state. Numba compiles one version for each module of kernels: inlining
    in all callbacks of the engine would double their compile time. A function made for each module
    would be new to numba in every process, and would keep numba from caching the callers on disk.
    """
    here, half = play[END], play[GAP] / 2
    torque = s[1] + value_of(polynomial, here)
    if abs(torque) <= ZERO:
        return min(max(here, angle - half), angle + half)
    half = math.copysign(half, torque)
    face, other = angle - half, angle + half
    if half * (here - face) <= 0:
        return face
    rest = opening(kernels, p, s, polynomial, limits, here, torque, face)
    return min(rest, other) if half > 0 else max(rest, other)


@njit(cache=True)
def is_free(torque, play, end, angle, delta):
    """Returns whether a motion that goes on with sign `delta` meets no torque at first.

    The suit's side is at the angle `end`, with a torque, and the joint at `angle`.
    """
    return abs(torque) <= ZERO and delta * (end - (angle - delta * play[GAP] / 2)) > 0


@cache
def follower(kernels: ModuleType) -> Callable[..., Any]:
    """Compiles the motion of a model behind play, once for each module of kernels.

    The function fills `torques` along `angles` from the second angle on, and moves s and `play`. At
    a pole s and `play` stay as they are, and all later torques are NaN.
    """
    version = stamp_of(kernels)

    @njit(cache=True)
    def follow(p, s, polynomial, limits, play, angles, torques):
        for i in range(1, angles.size if version >= 0 else 0):
            if angles[i] == angles[i - 1]:
                torques[i] = torques[i - 1]
                continue
            end = end_at(kernels, p, s, polynomial, limits, play, angles[i])
            inside = within(limits, end)
            if inside != s[0] and math.isnan(kernels.commit(p, s, inside)):
                torques[i:] = np.nan
                return
            play[END] = end
            torques[i] = s[1] + value_of(polynomial, end)

    return follow
