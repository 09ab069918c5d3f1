"""Kernels of Dahl's friction and the semilinear Duhem model, which differ in their config alone.

With d = sign(dtheta), the friction F of that way, w = d z / F and x = stiffness |dtheta| / F the
model reads dw/dx = 1 - w, so that w approaches 1 exponentially. A motion dissipates F^2 / stiffness
times the integral of w^2 dx. By completion of the square, the integral is

    (1 - exp(-2x)) / 2 (w + t)^2 + x - 2t,    t = tanh(x / 2)

where no term is ever negative.

Parameters p = [stiffness, friction up, friction down, coefficients of the spring].
"""

import math

from numba import njit

from ..polynomial import slope_of, value_of, work_of

STIFFNESS, UP, DOWN, SPRING = range(4)
ANGLE, TORQUE, LOSS, Z = range(4)
MEMORY_SIZE = 4
MOST_COEFFICIENTS = 6
ROUNDING = 1e-9  # share of z by which rounding may lift a saturated start above its limit
SHORT = 0.1  # x below which the series of x - 2 tanh(x / 2) has all digits


@njit(inline="always", error_model="numpy")
def least_area(x):
    """Returns x - 2 tanh(x / 2), the least integral of w^2 over a motion x."""
    if x > SHORT:
        return x - 2 * math.tanh(x / 2)
    u = x * x
    return x * u / 12 * (1 - u / 10 * (1 - 17 * u / 168 * (1 - 31 * u / 306)))


@njit(cache=True, error_model="numpy")
def move(p, s, angle):
    """Returns torque, loss and z after a monotone motion; NaN where they are not finite."""
    moved = abs(angle - s[ANGLE])
    limit = p[UP] if angle > s[ANGLE] else -p[DOWN]
    x = p[STIFFNESS] * moved / abs(limit)
    mean = s[Z] / limit + math.tanh(x / 2)
    area = -0.5 * math.expm1(-2 * x) * mean * mean + least_area(x)
    z = s[Z] - (limit - s[Z]) * math.expm1(-x)
    torque = value_of(p[SPRING:], angle) + z
    if not (moved < math.inf and abs(torque) < math.inf):
        return math.nan, 0.0, math.nan
    return torque, limit * limit / p[STIFFNESS] * area, z


@njit(inline="always", error_model="numpy")
def friction(p, s, angle, torque):
    """Returns z [N·m] at the end of a trial motion, computed from its torque."""
    return s[Z] if angle == s[ANGLE] else torque - value_of(p[SPRING:], angle)


@njit(cache=True, error_model="numpy")
def begin(p, s, angle, torque):
    """Starts a motion; returns how far z is inside its limits [N·m], negative if it is outside."""
    z = torque - value_of(p[SPRING:], angle)
    s[ANGLE], s[TORQUE], s[LOSS], s[Z] = angle, torque, 0.0, z
    if not abs(z) < math.inf:
        return math.nan
    return min(p[UP] - z, z + p[DOWN]) + ROUNDING * abs(z)


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
    limit = p[UP] if delta > 0 else -p[DOWN]
    slope = p[STIFFNESS] * (1 - friction(p, s, angle, torque) / limit)
    return slope_of(p[SPRING:], angle) + slope


@njit(cache=True, error_model="numpy")
def stored(p, s, angle, torque, loss):
    """Returns the energy stored at the end of a trial motion [J]."""
    z = friction(p, s, angle, torque)
    return work_of(p[SPRING:], angle) + 0.5 * z * z / p[STIFFNESS]


@njit(cache=True, error_model="numpy")
def dissipated(p, s, angle, torque, loss):
    """Returns the energy dissipated from the start to the end of a trial motion [J]."""
    return s[LOSS] + loss


@njit(cache=True, error_model="numpy")
def is_sound(p):
    """Returns whether the kernels can rely on p, which a user of the engine can overwrite."""
    return min(p[STIFFNESS], p[UP], p[DOWN]) > 0


@njit(cache=True)
def memory_size(total):
    """Returns how many of these `total` numbers belong to the memory."""
    return MEMORY_SIZE
