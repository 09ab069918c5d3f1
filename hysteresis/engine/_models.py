"""The models that the engine knows: their plugin names, config keys and kernels, by number."""

import math

from numba import njit

from ..bouc_wen import kernels as bouc_wen
from ..certificate import ROUNDING
from ..jiles_atherton import kernels as jiles_atherton
from ..jiles_atherton.margins import margin_in_range
from ..prandtl_ishlinskii import kernels as prandtl_ishlinskii
from ..preisach import kernels as preisach
from ..preisach._tables import parameter_size

JILES_ATHERTON, BOUC_WEN, PRANDTL_ISHLINSKII, PREISACH = range(4)
PLUGIN_NAMES = (
    "activesuit.jiles_atherton",
    "activesuit.bouc_wen",
    "activesuit.prandtl_ishlinskii",
    "activesuit.preisach",
)

# Config keys in the order in which MuJoCo stores their values: those of every model, then its own.
COMMON_KEYS = (
    "joint",
    "start_angle",
    "start_torque",
    "polynomial",
    "angle_range",
    "allow_uncertified",
)
JOINT, START_ANGLE, START_TORQUE, POLYNOMIAL, ANGLE_RANGE, ALLOW, FIRST_KEY = range(7)
OWN_KEYS = (
    ("Ms", "a", "alpha", "c", "k", "angle_unit", "form", "clamp"),
    ("elastic", "hysteretic", "A", "beta", "gamma", "n", "rest_angle"),
    ("stiffness", "rest_angle", "thresholds", "weights"),
    ("levels", "density", "elastic"),
)

LOSS, HEAD = 2, 3  # angle, torque and loss open every memory


@njit(inline="always")
def move(kind, p, s, angle):
    """Returns torque and loss after a monotone motion to `angle`."""
    if kind == JILES_ATHERTON:
        return jiles_atherton.move(p, s, angle)
    if kind == BOUC_WEN:
        return bouc_wen.move(p, s, angle)
    if kind == PRANDTL_ISHLINSKII:
        return prandtl_ishlinskii.move(p, s, angle)
    return preisach.move(p, s, angle)


@njit(inline="always")
def commit(kind, p, s, angle):
    """Moves the memory on to `angle`; returns the torque, NaN if there is none."""
    if kind == JILES_ATHERTON:
        return jiles_atherton.commit(p, s, angle)
    if kind == BOUC_WEN:
        return bouc_wen.commit(p, s, angle)
    if kind == PRANDTL_ISHLINSKII:
        return prandtl_ishlinskii.commit(p, s, angle)
    return preisach.commit(p, s, angle)


@njit(inline="always")
def stiffness(kind, p, s, angle, torque, delta):
    """Returns the slope of the torque if the motion goes on with sign `delta`."""
    if kind == JILES_ATHERTON:
        return jiles_atherton.stiffness(p, s, angle, torque, delta)
    if kind == BOUC_WEN:
        return bouc_wen.stiffness(p, s, angle, torque, delta)
    if kind == PRANDTL_ISHLINSKII:
        return prandtl_ishlinskii.stiffness(p, s, angle, torque, delta)
    return preisach.stiffness(p, s, angle, torque, delta)


@njit(inline="always")
def dissipated(kind, p, s, angle, torque, loss):
    """Returns the energy dissipated so far: the second result of the model's `energy`."""
    if kind == JILES_ATHERTON:
        return s[LOSS] + loss - jiles_atherton.recoverable(p, angle, torque)
    if kind == PREISACH:
        return preisach.energy(p, s, angle, torque, loss)[1]
    return s[LOSS] + loss


@njit(cache=True)
def begin(kind, p, s, angle, torque):
    """Fills the memory; returns how far inside the certificate the start is, NaN if impossible."""
    if kind == JILES_ATHERTON:
        return jiles_atherton.begin(p, s, angle, torque)
    if kind == BOUC_WEN:
        return bouc_wen.begin(p, s, angle, torque)
    if kind == PRANDTL_ISHLINSKII:
        return prandtl_ishlinskii.begin(p, s, angle, torque)
    return preisach.begin(p, s, angle, torque)


@njit(inline="always")
def is_sound(kind, p):
    """Returns whether a parameter vector, which a user can overwrite, cannot mislead a kernel."""
    if kind == JILES_ATHERTON:
        least = min(p[jiles_atherton.MS], p[jiles_atherton.A], p[jiles_atherton.K])
        return least > 0 and p[jiles_atherton.STEP_LIMIT] > 0
    if kind == BOUC_WEN:
        scale = min(p[bouc_wen.LOADING_SCALE], p[bouc_wen.UNLOADING_SCALE])
        return min(scale, p[bouc_wen.SLOPE]) > 0 and p[bouc_wen.POWER] >= 1
    return kind == PRANDTL_ISHLINSKII or parameter_size(p[0]) == p.size


@njit(cache=True)
def is_certified(kind, p):
    """Returns whether the torque stays finite and resistive in every motion."""
    if kind == JILES_ATHERTON:
        return jiles_atherton.is_certified(p)
    if kind == BOUC_WEN:
        return bouc_wen.is_certified(p)
    if kind == PRANDTL_ISHLINSKII:
        return prandtl_ishlinskii.is_certified(p)
    return preisach.is_certified(p)


@njit(cache=True)
def certified_in_range(kind, p, low, high):
    """Returns whether a model held outside a range is certified, and how far its start may be off.

    The distance is that from the torque at rest; it is infinite where `begin` alone decides.
    """
    if kind != JILES_ATHERTON or jiles_atherton.is_certified(p):
        return is_certified(kind, p), math.inf
    Ms, a, alpha, c, k = p[:5]
    margin, start, _ = margin_in_range(low, high, Ms, a, alpha, c, k)
    return jiles_atherton.is_exact(p) and c >= 1 and margin > ROUNDING, start


@njit(cache=True)
def sizes(kind, count):
    """Returns how many numbers memory and parameters have.

    `count` is the number of thresholds or segments, of models that have any.
    """
    if kind == JILES_ATHERTON:
        return jiles_atherton.MEMORY_SIZE, jiles_atherton.PARAMETER_SIZE
    if kind == BOUC_WEN:
        return bouc_wen.MEMORY_SIZE, bouc_wen.PARAMETER_SIZE
    if kind == PRANDTL_ISHLINSKII:
        return HEAD + count, prandtl_ishlinskii.HEADER + 2 * count
    return preisach.MEMORY_SIZE, parameter_size(count)
