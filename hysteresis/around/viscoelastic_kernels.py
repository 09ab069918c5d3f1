"""The torque of a dashpot and a Maxwell element, which `Viscoelastic` and the engine share.

The array `rate` holds damping [N·m·s/rad], and stiffness [N·m/rad] and relaxation time [s] of the
Maxwell element; then the memory: whether the motion has begun, the last angle [rad], the Maxwell
element's torque there [N·m], and the energy that both elements have dissipated [J].
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math

from numba import njit

DAMPING, STIFFNESS, TIME, BEGUN, ANGLE, TORQUE, LOSS, SIZE = range(8)
NUMBERS = 3  # parameters that a user gives


@njit(inline="always")
def is_sound(rate):
    """Returns whether the numbers, which a user can overwrite, make both elements passive."""
    for number in rate:
        if not math.isfinite(number):
            return False
    passive = min(rate[DAMPING], rate[STIFFNESS], rate[TIME]) >= 0
    return passive and (rate[TIME] > 0 or rate[STIFFNESS] == 0)


def carried(rate, other):
    """Returns the parameters of `rate` with the memory of `other`; the deflection stays."""
    found = other.copy()
    found[:NUMBERS] = rate[:NUMBERS]
    found[TORQUE] *= rate[STIFFNESS] / other[STIFFNESS] if other[STIFFNESS] > 0 else 0.0
    return found


@njit(inline="always")
def torque_at(rate, angle, velocity):
    """Returns the torque at an angle that the joint has just reached [N·m]."""
    torque = rate[TORQUE] + rate[DAMPING] * velocity
    if rate[BEGUN] != 0 and angle != rate[ANGLE]:
        torque += rate[STIFFNESS] * (angle - rate[ANGLE])
    return torque


@njit(inline="always")
def relax(rate, angle, elapsed):
    """Moves `rate` to an angle at a constant speed, in place; both elements start relaxed.

    For a constant speed v the solution is exact: the Maxwell element's torque goes from T to
    k tau v + (T - k tau v) exp(-t / tau), and the element dissipates the integral of
    T^2 / (k tau), which is its work less the change of the stored energy.
    """
    if rate[BEGUN] == 0:
        rate[BEGUN], rate[ANGLE] = 1.0, angle
        return
    moved = angle - rate[ANGLE]
    rate[ANGLE] = angle
    rate[LOSS] += rate[DAMPING] * moved * moved / elapsed
    if rate[STIFFNESS] > 0:
        k, time, torque = rate[STIFFNESS], rate[TIME], rate[TORQUE]
        faded = -math.expm1(-elapsed / time)
        steady = k * time * moved / elapsed
        rate[TORQUE] = torque + (steady - torque) * faded
        work = moved * (steady + (torque - steady) * faded * time / elapsed)
        stored = (rate[TORQUE] ** 2 - torque**2) / (2 * k)
        rate[LOSS] += max(work - stored, 0.0)


@njit(cache=True)
def follow(rate, time, angle, torque):
    """Fills `torque` with that of the Maxwell element along a motion [N·m], from relaxed on."""
    for i in range(angle.size):
        elapsed = time[i] - time[i - 1] if i > 0 else 0.0
        relax(rate, angle[i], elapsed)
        torque[i] = rate[TORQUE]
