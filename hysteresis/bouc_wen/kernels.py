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
PARAMETER_SIZE = 9
ANGLE, TORQUE, LOSS, Z = range(4)
MEMORY_SIZE = 4
LARGEST_POWER = 1e6  # there w^n keeps 10 of its 16 digits
FINE, NOT_ZERO, POSITIVE, FROM_1_TO_1E6 = range(4)
COMPLAINTS = (
    b"",
    b"give a number other than 0",
    b"give a number above 0",
    b"give a number from 1 to 1e6",
)
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
def certify(p, s, inside, low, high):
    """Returns whether z stays finite and no motion at any angles gains energy, and `inside`.

    The signs of both branches follow from hysteretic beta >= |hysteretic gamma|.
    """
    loading, unloading = p[LOADING_SIGN], p[UNLOADING_SIGN]
    if p[HYSTERETIC] > 0:
        return loading >= 0 and unloading <= 0, inside
    return p[POWER] == 1 and loading <= 0 and unloading >= 0, inside


@njit(cache=True, error_model="numpy")
def is_sound(p):
    """Returns whether the kernels can rely on p, which a user of the engine can overwrite."""
    if not (min(p[LOADING_SCALE], p[UNLOADING_SCALE], p[SLOPE]) > 0 and p[POWER] >= 1):
        return False
    return p[LOADING_SIGN] in (-1, 0, 1) and p[UNLOADING_SIGN] in (-1, 0, 1)


@njit(cache=True)
def size(counts):
    """Returns how many numbers memory and parameters have together."""
    return MEMORY_SIZE + PARAMETER_SIZE


@njit(cache=True)
def memory_size(total):
    """Returns how many of these `total` numbers belong to the memory."""
    return MEMORY_SIZE


@njit(cache=True, error_model="numpy")
def complaint(values, ends):
    """Returns the complaint about elastic, hysteretic, A, beta, gamma, n and the rest angle."""
    _, hysteretic, A, _, _, n, _ = values
    if hysteretic == 0:
        return NOT_ZERO, 1
    if not A > 0:
        return POSITIVE, 2
    if not 1 <= n <= LARGEST_POWER:
        return FROM_1_TO_1E6, 5
    return FINE, 0


@njit(cache=True, error_model="numpy")
def configure(values, ends, p):
    """Fills p with the values of all keys, and with the scale and sign of both branches."""
    elastic, hysteretic, A, beta, gamma, n, rest_angle = values
    p[ELASTIC], p[HYSTERETIC], p[REST], p[SLOPE], p[POWER] = elastic, hysteretic, rest_angle, A, n
    for at, curvature in ((LOADING_SCALE, beta + gamma), (UNLOADING_SCALE, gamma - beta)):
        ratio = A / abs(curvature) if curvature != 0 else math.inf
        # A curvature too small for a finite ratio counts as 0.
        p[at] = ratio ** (1 / n) if ratio < math.inf else 1.0
        p[at + 1] = math.copysign(1.0, curvature) if ratio < math.inf else 0.0
