"""The force law of a bushing, and how a force between two bodies reaches the joints.

Vectors are tuples of three numbers: they cost no memory. Rotation matrices are rows of nine.
"""

# pyright: reportCallIssue=false

import math

from numba import njit

SMALL_ANGLE = 0.1  # [rad], angle below which the series of `curvature` is exact to rounding

# First indices of a bushing's parameters in its parameter vector, three numbers each.
STIFFNESS, ROTATIONAL_STIFFNESS, DAMPING, ROTATIONAL_DAMPING, OFFSET = range(0, 15, 3)
PARAMETER_SIZE = 15


@njit(inline="always")
def dot(a, b):
    """Returns the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(inline="always")
def cross(a, b):
    """Returns the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(inline="always")
def add(a, b):
    """Returns a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(inline="always")
def subtract(a, b):
    """Returns a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(inline="always")
def scale(factor, a):
    """Returns factor a."""
    return factor * a[0], factor * a[1], factor * a[2]


@njit(inline="always")
def triple(values, first):
    """Returns three consecutive numbers of an array."""
    return values[first], values[first + 1], values[first + 2]


@njit(inline="always")
def column(R, i):
    """Returns the axis number i of a frame."""
    return R[i], R[3 + i], R[6 + i]


@njit(inline="always")
def into(R, a):
    """Returns R^T a: a vector of the world in the axes of a frame."""
    return dot(column(R, 0), a), dot(column(R, 1), a), dot(column(R, 2), a)


@njit(inline="always")
def out_of(R, a):
    """Returns R a: a vector of a frame in the axes of the world."""
    return dot(triple(R, 0), a), dot(triple(R, 3), a), dot(triple(R, 6), a)


@njit(cache=True)
def half_turn(x, y, z):
    """Returns cosine and rotation axis times sine of half the angle of a rotation.

    The arguments are the columns of its matrix. The divisor is the largest of the four squares, so
    no precision is lost near any angle; the cosine is never negative, so the angle is at most pi.
    """
    trace = x[0] + y[1] + z[2]
    skew = y[2] - z[1], z[0] - x[2], x[1] - y[0]
    if trace >= max(x[0], y[1], z[2]):
        w = 1 + trace
        v = skew
    elif x[0] >= max(y[1], z[2]):
        w = skew[0]
        v = 1 + x[0] - y[1] - z[2], x[1] + y[0], x[2] + z[0]
    elif y[1] >= z[2]:
        w = skew[1]
        v = x[1] + y[0], 1 - x[0] + y[1] - z[2], y[2] + z[1]
    else:
        w = skew[2]
        v = x[2] + z[0], y[2] + z[1], 1 - x[0] - y[1] + z[2]
    norm = math.copysign(math.sqrt(w * w + dot(v, v)), w)
    return w / norm, scale(1 / norm, v)


@njit(cache=True)
def curvature(angle, cosine, sine):
    """Returns (1 - (angle/2) cot(angle/2)) / angle^2 from the cosine and the sine of angle/2."""
    square = angle * angle
    if angle < SMALL_ANGLE:
        return 1 / 12 + square * (1 / 720 + square * (1 / 30240 + square / 1209600))
    return (1 - 0.5 * angle * cosine / sine) / square


@njit(inline="always")
def weighted(p, first, a):
    """Returns a vector times a diagonal matrix of the parameters."""
    return p[first] * a[0], p[first + 1] * a[1], p[first + 2] * a[2]


@njit(cache=True)
def load(p, arm, Ra, Rb, rate, spin):
    """Returns force, torque on the limb in the axes of the exoskeleton's site, and stored energy.

    With d = Rb^T arm - offset and phi = log(Rb^T Ra), the energy is d.K d / 2 + phi.Kr phi / 2. Its
    gradient has J(phi)^-T = 1 + [phi] / 2 + c [phi]^2, the inverse transpose of the left Jacobian
    of rotations (Chirikjian and Kyatkin 2001, Engineering Applications of Noncommutative Harmonic
    Analysis, section 5.3).

    Args:
        p: Parameters of the bushing.
        arm: Vector from the exoskeleton's site to the limb's, in the axes of the world.
        Ra: Axes of the limb's site.
        Rb: Axes of the exoskeleton's site.
        rate: Velocity of the limb's site relative to the exoskeleton's body, in the world.
        spin: Angular velocity of the limb relative to the exoskeleton.
    """
    d = subtract(into(Rb, arm), triple(p, OFFSET))
    cosine, v = half_turn(into(Rb, column(Ra, 0)), into(Rb, column(Ra, 1)), into(Rb, column(Ra, 2)))
    sine = math.sqrt(dot(v, v))
    angle = 2 * math.atan2(sine, cosine)
    phi = scale(angle / sine if sine > 0 else 2.0, v)
    pull, moment = weighted(p, STIFFNESS, d), weighted(p, ROTATIONAL_STIFFNESS, phi)
    energy = 0.5 * (dot(pull, d) + dot(moment, phi))
    swerve = cross(phi, moment)
    torque = add(moment, scale(0.5, swerve))
    torque = add(torque, scale(curvature(angle, cosine, sine), cross(phi, swerve)))
    pull = add(pull, weighted(p, DAMPING, into(Rb, rate)))
    torque = add(torque, weighted(p, ROTATIONAL_DAMPING, into(Rb, spin)))
    return scale(-1.0, pull), scale(-1.0, torque), energy
