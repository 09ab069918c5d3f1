"""The force law of a bushing, compiled for the engine.

Vectors are tuples of three numbers: they cost no memory. Rotation matrices are rows of nine.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from collections import namedtuple

import numpy as np
from numba import njit

from ...hysteresis.engine.native import (
    doubles,
    int32_at,
    packed,
    pointer_at,
    sensor_values,
    state_of,
    word_of,
)

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
    """Returns axis number i of the frame R."""
    return R[i], R[3 + i], R[6 + i]


@njit(inline="always")
def into(R, a):
    """Returns R^T a: the vector a of the world, in the axes of the frame R."""
    return dot(column(R, 0), a), dot(column(R, 1), a), dot(column(R, 2), a)


@njit(inline="always")
def out_of(R, a):
    """Returns R a: the vector a of the frame R, in the axes of the world."""
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
    Analysis, section 5.3). Ra and Rb are the axes of the limb's site and of the exoskeleton's;
    `arm`, rate and spin are those of the first relative to the second, in the axes of the world.
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


BITS = 12  # of five numbers in the word of an instance: two sites and three sensors
WIDTH = np.int64(BITS)
LIMB, EXO = range(2)
FORCE_SENSOR, TORQUE_SENSOR, ENERGY_SENSOR = map(np.int64, (2, 3, 4))

Layout = namedtuple(
    "Layout",
    "m_body_parentid m_body_rootid m_body_dofnum m_body_dofadr m_dof_parentid m_site_bodyid "
    "m_sensor_adr m_plugin_stateadr d_qfrc_passive d_site_xpos d_site_xmat d_subtree_com d_cdof "
    "d_cvel d_sensordata d_plugin_state d_plugin_data mjPLUGIN_PASSIVE",
)
"""The fields of mjModel (m_) and mjData (d_) that a bushing touches, and values of enums."""


@njit(inline="always")
def site_frame(d, site, at):
    """Returns position and axes of a site, as views."""
    position = doubles(pointer_at(d + at.d_site_xpos) + 24 * site, 3)
    return position, doubles(pointer_at(d + at.d_site_xmat) + 72 * site, 9)


@njit(cache=True)
def lever(m, d, body, point, at):
    """Returns the vector from the reference point of a body's motion (cvel, cdof) to a point."""
    root = int32_at(pointer_at(m + at.m_body_rootid), body)
    return subtract(point, triple(doubles(pointer_at(d + at.d_subtree_com) + 24 * root, 3), 0))


@njit(cache=True)
def motion_at(m, d, body, point, at):
    """Returns angular velocity of a body, and velocity of the body at a point of the world."""
    velocity = doubles(pointer_at(d + at.d_cvel) + 48 * body, 6)
    spin = triple(velocity, 0)
    return spin, add(triple(velocity, 3), cross(spin, lever(m, d, body, point, at)))


@njit(cache=True)
def push(m, d, body, point, force, torque, at):
    """Adds a force at a point of a body, and a torque, to the passive forces of its joints."""
    torque = add(torque, cross(lever(m, d, body, point, at), force))
    parents, counts = pointer_at(m + at.m_body_parentid), pointer_at(m + at.m_body_dofnum)
    while body > 0 and int32_at(counts, body) == 0:
        body = int32_at(parents, body)
    if body == 0:
        return
    dof = int32_at(pointer_at(m + at.m_body_dofadr), body) + int32_at(counts, body) - 1
    parents = pointer_at(m + at.m_dof_parentid)
    cdof, passive = pointer_at(d + at.d_cdof), pointer_at(d + at.d_qfrc_passive)
    while dof >= 0:
        axis = doubles(cdof + 48 * dof, 6)
        work = dot(triple(axis, 0), torque) + dot(triple(axis, 3), force)
        doubles(passive + 8 * dof, 1)[0] += work
        dof = int32_at(parents, dof)


@njit(cache=True)
def evaluate(m, d, instance, capability, at):
    """Adds the forces at the current position and velocity, or writes the sensors."""
    ids = word_of(d, instance, at)
    p = doubles(state_of(m, d, instance, at), PARAMETER_SIZE)
    limb_site, exo_site = packed(ids, LIMB, WIDTH), packed(ids, EXO, WIDTH)
    position, Ra = site_frame(d, limb_site, at)
    origin, Rb = site_frame(d, exo_site, at)
    bodies = pointer_at(m + at.m_site_bodyid)
    limb, exo = int32_at(bodies, limb_site), int32_at(bodies, exo_site)
    point = triple(position, 0)
    limb_spin, limb_velocity = motion_at(m, d, limb, point, at)
    exo_spin, exo_velocity = motion_at(m, d, exo, point, at)
    rate, spin = subtract(limb_velocity, exo_velocity), subtract(limb_spin, exo_spin)
    force, torque, energy = load(p, subtract(point, triple(origin, 0)), Ra, Rb, rate, spin)
    if capability == at.mjPLUGIN_PASSIVE:
        force, torque = out_of(Rb, force), out_of(Rb, torque)
        push(m, d, limb, point, force, torque, at)
        push(m, d, exo, point, scale(-1.0, force), scale(-1.0, torque), at)
        return
    write(m, d, packed(ids, FORCE_SENSOR, WIDTH), force, at)
    write(m, d, packed(ids, TORQUE_SENSOR, WIDTH), torque, at)
    write(m, d, packed(ids, ENERGY_SENSOR, WIDTH), (energy,), at)


@njit(inline="always")
def write(m, d, sensor, values, at):
    """Writes the values of a sensor, if there is one."""
    if sensor >= 0:
        data = sensor_values(m, d, sensor, len(values), at)
        for i in range(len(values)):
            data[i] = values[i]
