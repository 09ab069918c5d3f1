"""Kernels of the Bouc-Wen model: plain functions over scalars and arrays, compiled by numba.

With d = sign(dtheta), y = d z and tau = |dtheta| the model reads dy/dtau = A - Q |y|^n, where Q is
beta + gamma while y > 0 (loading) and gamma - beta while y < 0 (unloading). In units of
Y = (A / |Q|)^(1/n), with w = |y| / Y, x = A tau / Y and sigma = sign(Q), that is

    dw/dx = 1 - sigma w^n  (loading)      dw/dx = -(1 - sigma w^n)  (unloading, until w = 0)

and a motion dissipates +sigma (loading) or -sigma (unloading) times hysteretic Y^2 / A times the
integral of w^(n+1) |dx|.
"""

import math

from numba import njit

from ._flow import flow

ELASTIC, HYSTERETIC, REST, SLOPE, POWER = range(5)
LOADING_SCALE, LOADING_SIGN, UNLOADING_SCALE, UNLOADING_SIGN = range(5, 9)
ANGLE, TORQUE, LOSS, Z = range(4)
MEMORY_SIZE = 4
LARGEST_POWER = 1e6  # there w^n keeps 10 of its 16 digits
ROUNDING = 1e-9  # share of z by which rounding may lift a saturated start above the bound


@njit(cache=True, error_model="numpy")
def move(p, s, angle):
    """Returns torque, loss and z after a monotone motion to another angle; NaN past a pole."""
    tau = abs(angle - s[ANGLE])
    if not tau < math.inf:
        return math.nan, 0.0, math.nan
    delta = 1.0 if angle > s[ANGLE] else -1.0
    n, A = p[POWER], p[SLOPE]
    y = delta * s[Z]
    loss = 0.0
    # A motion against z unloads first; `rest` is the part of the motion that is left at z = 0.
    if y < 0:
        Y, sigma = p[UNLOADING_SCALE], p[UNLOADING_SIGN]
        w, rest, area = flow(-y / Y, tau * A / Y, sigma, -1.0, n)
        y, tau = -w * Y, rest * Y / A
        loss -= sigma * Y * Y * area
    if tau > 0:
        Y, sigma = p[LOADING_SCALE], p[LOADING_SIGN]
        w, _, area = flow(y / Y, tau * A / Y, sigma, 1.0, n)
        y = w * Y
        loss += sigma * Y * Y * area
    z = delta * y
    torque = p[ELASTIC] * (angle - p[REST]) + p[HYSTERETIC] * z
    return torque if abs(torque) < math.inf else math.nan, p[HYSTERETIC] / A * loss, z


@njit(inline="always", error_model="numpy")
def memory_variable(p, s, angle, torque):
    """Returns z [rad] at the end of a trial motion, computed from its torque."""
    if angle == s[ANGLE]:
        return s[Z]
    return (torque - p[ELASTIC] * (angle - p[REST])) / p[HYSTERETIC]


@njit(cache=True, error_model="numpy")
def bound(p):
    """Returns `BoucWen.z_bound` [rad], which `BoucWen.certificate` proves."""
    if p[LOADING_SIGN] <= 0:
        return math.inf
    if p[UNLOADING_SIGN] > 0 and p[UNLOADING_SCALE] < p[LOADING_SCALE]:
        return math.inf
    return p[LOADING_SCALE]


@njit(cache=True, error_model="numpy")
def begin(p, s, angle, torque):
    """Starts a motion; returns how far |z| [rad] is below its bound, negative if it is above."""
    z = (torque - p[ELASTIC] * (angle - p[REST])) / p[HYSTERETIC]
    s[ANGLE], s[TORQUE], s[LOSS], s[Z] = angle, torque, 0.0, z
    if not abs(z) < math.inf:
        return math.nan
    return bound(p) - abs(z) + ROUNDING * abs(z)


@njit(cache=True, error_model="numpy")
def commit(p, s, angle):
    """Moves the memory on to `angle` and returns the torque; NaN leaves s as it is."""
    if angle == s[ANGLE]:
        return s[TORQUE]
    torque, loss, z = move(p, s, angle)
    if not math.isnan(torque):
        s[ANGLE], s[TORQUE], s[Z] = angle, torque, z
        s[LOSS] += loss
    return torque


@njit(cache=True, error_model="numpy")
def stiffness(p, s, angle, torque, delta):
    """Returns dT/dtheta [N·m/rad] for a motion that goes on with sign `delta`."""
    y = delta * memory_variable(p, s, angle, torque)
    scale, sign = (LOADING_SCALE, LOADING_SIGN) if y >= 0 else (UNLOADING_SCALE, UNLOADING_SIGN)
    bend = p[sign] * (abs(y) / p[scale]) ** p[POWER]
    return p[ELASTIC] + p[HYSTERETIC] * p[SLOPE] * (1 - bend)


@njit(cache=True, error_model="numpy")
def stored(p, s, angle, torque, loss):
    """Returns the energy stored at the end of a trial motion [J]."""
    z = memory_variable(p, s, angle, torque)
    strain = angle - p[REST]
    return 0.5 * p[ELASTIC] * strain * strain + 0.5 * p[HYSTERETIC] / p[SLOPE] * z * z


@njit(cache=True, error_model="numpy")
def dissipated(p, s, angle, torque, loss):
    """Returns the energy dissipated from the start to the end of a trial motion [J]."""
    return s[LOSS] + loss


@njit(cache=True, error_model="numpy")
def is_sound(p):
    """Returns whether the kernels can rely on p, which a user of the engine can overwrite."""
    if not (min(p[LOADING_SCALE], p[UNLOADING_SCALE], p[SLOPE]) > 0 and p[POWER] >= 1):
        return False
    return p[LOADING_SIGN] in (-1, 0, 1) and p[UNLOADING_SIGN] in (-1, 0, 1)


@njit(cache=True)
def memory_size(total):
    """Returns how many of these `total` numbers belong to the memory."""
    return MEMORY_SIZE
