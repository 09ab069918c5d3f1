"""Sets an instance up from its MJCF config: its joint, sensors, parameters and memory."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math

import numpy as np
from numba import njit

from ..jiles_atherton.kernels import LAG
from ._faults import (
    FAR_START,
    FINE,
    FLAG,
    JOINT_TWICE,
    JOINT_TYPE,
    NO_JOINT,
    NO_START,
    NUMBERS,
    RANGE,
    REASONS,
    SENSOR_NAME,
    SENSOR_TWICE,
    TOO_LARGE,
    TOO_MANY,
    UNCERTIFIED,
    config,
    plugin_of,
)
from ._models import (
    ALLOW,
    ANGLE_RANGE,
    BOUC_WEN,
    JILES_ATHERTON,
    JOINT,
    POLYNOMIAL,
    PRANDTL_ISHLINSKII,
    PREISACH,
    START_ANGLE,
    START_TORQUE,
    begin,
    certified_in_range,
    is_certified,
)
from ._parameters import count_parts, read_optional, read_parameters
from ._state import (
    BITS,
    ENERGY_SENSOR,
    HELD_SHIFT,
    LARGEST,
    MODEL_SHIFT,
    POLYNOMIAL_LIMIT,
    POLYNOMIAL_SHIFT,
    STIFFNESS_SENSOR,
    TORQUE_SENSOR,
    joint_of,
    kind_of,
    parts,
    sensor_of,
    state_size,
)
from .native._memory import doubles, int32_at, name2id, pointer_at
from .native._text import count_words, ends_with, equals, length, parse_numbers


@njit(cache=True)
def is_ours(name):
    """Returns whether a plugin's name is one of ours."""
    return (
        equals(name, b"activesuit.jiles_atherton")
        or equals(name, b"activesuit.bouc_wen")
        or equals(name, b"activesuit.prandtl_ishlinskii")
        or equals(name, b"activesuit.preisach")
    )


@njit(cache=True)
def model_kind(m, instance, at):
    """Returns the number of an instance's model, by the name of its plugin."""
    name = pointer_at(plugin_of(m, instance, at))
    if ends_with(name, b"jiles_atherton"):
        return JILES_ATHERTON
    if ends_with(name, b"bouc_wen"):
        return BOUC_WEN
    return PRANDTL_ISHLINSKII if ends_with(name, b"prandtl_ishlinskii") else PREISACH


@njit(cache=True)
def required_size(m, instance, at):
    """Returns how many numbers of plugin_state an instance needs."""
    kind = model_kind(m, instance, at)
    more = polynomial_size(m, instance, at) + 2 * is_held(m, instance, at)
    return state_size(kind, count_parts(kind, m, instance, at)) + more


@njit(cache=True)
def polynomial_size(m, instance, at):
    """Returns how many coefficients an instance's elastic polynomial has."""
    return min(count_words(config(m, instance, POLYNOMIAL, at)), POLYNOMIAL_LIMIT)


@njit(cache=True)
def is_held(m, instance, at):
    """Returns 1 if an instance holds its torque outside a range of angles, else 0."""
    return 1 if count_words(config(m, instance, ANGLE_RANGE, at)) > 0 else 0


@njit(cache=True)
def sensor_kind(name):
    """Returns what a sensor measures, as its name says, or -1."""
    if ends_with(name, b"torque"):
        return TORQUE_SENSOR
    if ends_with(name, b"stiffness"):
        return STIFFNESS_SENSOR
    return ENERGY_SENSOR if ends_with(name, b"energy") else -1


@njit(cache=True)
def connect(m, instance, at):
    """Returns (fault, packed numbers of the model, the joint and this instance's sensors)."""
    if max(pointer_at(m + at.m_njnt), pointer_at(m + at.m_nsensor)) >= LARGEST:
        return TOO_LARGE, 0
    joint = name2id(m, at.object_joint, config(m, instance, JOINT, at))
    if joint < 0:
        return NO_JOINT, 0
    joint_type = int32_at(pointer_at(m + at.m_jnt_type), joint)
    if joint_type not in (at.joint_slide, at.joint_hinge):
        return JOINT_TYPE, 0
    for other in range(instance):
        ours = is_ours(pointer_at(plugin_of(m, other, at)))
        if ours and name2id(m, at.object_joint, config(m, other, JOINT, at)) == joint:
            return JOINT_TWICE, 0
    wires = joint | model_kind(m, instance, at) << MODEL_SHIFT
    wires |= polynomial_size(m, instance, at) << POLYNOMIAL_SHIFT
    wires |= is_held(m, instance, at) << HELD_SHIFT
    for i in range(pointer_at(m + at.m_nsensor)):
        ours = int32_at(pointer_at(m + at.m_sensor_plugin), i) == instance
        if ours and int32_at(pointer_at(m + at.m_sensor_type), i) == at.sensor_plugin:
            name = pointer_at(m + at.m_names) + int32_at(pointer_at(m + at.m_name_sensoradr), i)
            kind = sensor_kind(name)
            if kind < 0:
                return SENSOR_NAME, 0
            if sensor_of(wires, kind) >= 0:
                return SENSOR_TWICE, 0
            wires |= (i + 1) << (BITS * kind)
    return FINE, wires


@njit(cache=True)
def configure(m, instance, wires, address, size, at):
    """Fills the state from the config; returns a fault for `complain`, FINE if it could."""
    kind = kind_of(wires)
    flag, memory, p, polynomial, limits = parts(wires, address, size)
    flag[0] = 1.0
    fault = read_parameters(kind, m, instance, p, at)
    if fault == FINE:
        fault = read_polynomial(m, instance, polynomial, at)
    if fault == FINE:
        fault = read_range(m, instance, limits, at)
    if fault == FINE:
        fault = start(kind, m, instance, joint_of(wires), memory, p, polynomial, limits, at)
    flag[0] = fault != FINE
    return fault


@njit(cache=True)
def read_polynomial(m, instance, polynomial, at):
    """Reads the coefficients of the elastic polynomial; there may be none."""
    count = parse_numbers(config(m, instance, POLYNOMIAL, at), polynomial)
    if count < 0:
        return NUMBERS + REASONS * POLYNOMIAL
    return FINE if count <= POLYNOMIAL_LIMIT else TOO_MANY + REASONS * POLYNOMIAL


@njit(cache=True)
def read_range(m, instance, limits, at):
    """Reads lowest and highest angle, if the torque is held outside a range."""
    if limits.size == 0:
        return FINE
    count = parse_numbers(config(m, instance, ANGLE_RANGE, at), limits)
    return FINE if count == 2 and limits[0] < limits[1] else RANGE + REASONS * ANGLE_RANGE


@njit(cache=True)
def start(kind, m, instance, joint, memory, p, polynomial, limits, at):
    """Puts the memory at the start, by default the joint's reference position and no torque.

    Refuses parameters without a certificate, and starts outside it, unless told otherwise.
    """
    qpos = int32_at(pointer_at(m + at.m_jnt_qposadr), joint)
    at_start = np.zeros(2)
    at_start[0] = doubles(pointer_at(m + at.m_qpos0), qpos + 1)[qpos]
    fault = read_optional(m, instance, START_ANGLE, at_start[:1], at)
    if fault == FINE:
        fault = read_optional(m, instance, START_TORQUE, at_start[1:], at)
    if fault != FINE:
        return fault
    flag = config(m, instance, ALLOW, at)
    allowed = equals(flag, b"true")
    if not (allowed or equals(flag, b"false") or length(flag) == 0):
        return FLAG + REASONS * ALLOW
    certified, reach = is_certified(kind, p), math.inf
    if limits.size > 0:
        certified, reach = certified_in_range(kind, p, limits[0], limits[1])
    if not (allowed or certified):
        return UNCERTIFIED
    angle, torque = at_start[0], at_start[1] - value_of(polynomial, at_start[0])
    if limits.size > 0:
        angle = min(max(angle, limits[0]), limits[1])
    inside = begin(kind, p, memory, angle, torque)
    if math.isnan(inside):
        return NO_START
    if reach < math.inf:
        inside = reach - abs(memory[LAG])
    return FINE if allowed or inside >= 0 else FAR_START


@njit(inline="always")
def value_of(polynomial, angle):
    """Returns the elastic torque of the polynomial."""
    value = 0.0
    for power in range(polynomial.size - 1, -1, -1):
        value = value * angle + polynomial[power]
    return value


@njit(inline="always")
def slope_of(polynomial, angle):
    """Returns its derivative."""
    slope = 0.0
    for power in range(polynomial.size - 1, 0, -1):
        slope = slope * angle + power * polynomial[power]
    return slope
