"""Reading an instance's MJCF config into its state, and saying what is wrong with it."""

# pyright: reportCallIssue=false

import math

from numba import njit

from .. import _jiles_atherton_kernels as kernels
from ._memory import character_at, doubles, int32_at, name2id, parse_double, pointer_at, warn
from ._state import (
    ALPHA,
    ANGLE,
    DOF,
    ENERGY_SENSOR,
    FAULT,
    LOSS,
    MS,
    QPOS,
    STEP_LIMIT,
    STIFFNESS_SENSOR,
    TORQUE,
    TORQUE_SENSOR,
    A,
    C,
    K,
)

# Config keys, in the order in which MuJoCo stores their values.
ATTRIBUTES = (
    "joint",
    "Ms",
    "a",
    "alpha",
    "c",
    "k",
    "angle_unit",
    "start_angle",
    "start_torque",
    "allow_uncertified",
)
JOINT, FIRST_PARAMETER, UNIT, START_ANGLE, START_TORQUE, ALLOW = 0, 1, 6, 7, 8, 9

# What can be wrong with a config.
FINE, NO_JOINT, JOINT_TYPE, PARAMETER, NOT_POSITIVE, ANGLE_UNIT = 0, 1, 2, 3, 4, 5
START, UNCERTIFIED, SENSOR_NAME = 6, 7, 8

DEGREE = math.pi / 180


@njit(cache=True)
def config(m, instance, index, at):
    """Returns the address of the config value number `index`, a C string ("" if not given)."""
    text = pointer_at(m + at.m_plugin_attr) + int32_at(
        pointer_at(m + at.m_plugin_attradr), instance
    )
    for _ in range(index):
        while character_at(text) != 0:
            text += 1
        text += 1
    return text


@njit(cache=True)
def ends_with(text, ending):
    """Returns whether the C string at `text` ends with the bytes `ending`."""
    length = 0
    while character_at(text + length) != 0:
        length += 1
    if length < len(ending):
        return False
    for i in range(len(ending)):
        if character_at(text + length - len(ending) + i) != ending[i]:
            return False
    return True


@njit(cache=True)
def sensor_slot(name):
    """Returns the state slot of what a sensor's name says it measures, or -1."""
    if ends_with(name, b"torque"):
        return TORQUE_SENSOR
    if ends_with(name, b"stiffness"):
        return STIFFNESS_SENSOR
    if ends_with(name, b"energy"):
        return ENERGY_SENSOR
    return -1


@njit(cache=True)
def stored_energy(state, angle, torque):
    """Returns what a motion from here could still get back of the path part of the work [J]."""
    return kernels.recoverable_energy(
        angle, torque, state[MS], state[A], state[ALPHA], state[C], state[K], state[STEP_LIMIT]
    )


@njit(cache=True)
def certified(state):
    """Mirrors `JilesAtherton.certificate` and the start's memory bound."""
    chi = state[MS] / (3 * state[A])
    spread = abs(state[C] - 1)
    alpha = state[ALPHA]
    top = alpha * (spread + max(state[C], 0.0)) * chi
    bottom = -alpha * (spread + max(-state[C], 0.0)) * chi
    man = state[MS] * kernels.langevin((state[ANGLE] + alpha * state[TORQUE]) / state[A])[0]
    inside = abs(state[TORQUE] - man) <= state[K] * spread * chi
    return top < 1 and bottom < 1 and state[C] >= 1 and inside


@njit(cache=True)
def configure(m, instance, state, at):
    """Fills the state from the config; returns a fault code for `complain`, FINE if it could."""
    fault = find_joint(m, instance, state, at)
    if fault == FINE:
        fault = read_parameters(m, instance, state, at)
    if fault == FINE:
        fault = read_start(m, instance, state, at)
    if fault == FINE:
        allowed = character_at(config(m, instance, ALLOW, at)) == ord("t")
        fault = FINE if allowed or certified(state) else UNCERTIFIED
    if fault == FINE:
        fault = find_sensors(m, instance, state, at)
    state[LOSS] = stored_energy(state, state[ANGLE], state[TORQUE]) if fault == FINE else 0.0
    state[FAULT] = 0.0
    return fault


@njit(cache=True)
def find_joint(m, instance, state, at):
    """Resolves the name of the joint."""
    joint = name2id(m, at.object_joint, config(m, instance, JOINT, at))
    if joint < 0:
        return NO_JOINT
    joint_type = int32_at(pointer_at(m + at.m_jnt_type), joint)
    if joint_type not in (at.joint_slide, at.joint_hinge):
        return JOINT_TYPE
    state[QPOS] = int32_at(pointer_at(m + at.m_jnt_qposadr), joint)
    state[DOF] = int32_at(pointer_at(m + at.m_jnt_dofadr), joint)
    return FINE


@njit(cache=True)
def read_parameters(m, instance, state, at):
    """Reads Ms, a, alpha, c, k and turns them into radians."""
    for i in range(5):
        value, number = parse_double(config(m, instance, FIRST_PARAMETER + i, at))
        if not (number and math.isfinite(value)):
            return PARAMETER
        state[MS + i] = value
    if not (state[MS] > 0 and state[A] > 0 and state[K] > 0):
        return NOT_POSITIVE
    unit = character_at(config(m, instance, UNIT, at))
    if unit == ord("d"):
        state[A] *= DEGREE
        state[ALPHA] *= DEGREE
        state[K] *= DEGREE
    elif unit != ord("r"):
        return ANGLE_UNIT
    state[STEP_LIMIT] = kernels.field_step_limit(
        state[MS], state[A], state[ALPHA], state[C], state[K]
    )
    return FINE


@njit(cache=True)
def read_start(m, instance, state, at):
    """Puts the memory at the start, by default the joint's reference position and no torque."""
    qpos = int(state[QPOS])
    state[ANGLE] = doubles(pointer_at(m + at.m_qpos0), qpos + 1)[qpos]
    state[TORQUE] = 0.0
    for slot, key in ((ANGLE, START_ANGLE), (TORQUE, START_TORQUE)):
        text = config(m, instance, key, at)
        if character_at(text) != 0:
            value, number = parse_double(text)
            if not (number and math.isfinite(value)):
                return START
            state[slot] = value
    return FINE


@njit(cache=True)
def find_sensors(m, instance, state, at):
    """Looks up where the sensors of this instance write."""
    state[TORQUE_SENSOR] = state[STIFFNESS_SENSOR] = state[ENERGY_SENSOR] = -1.0
    for i in range(pointer_at(m + at.m_nsensor)):
        ours = int32_at(pointer_at(m + at.m_sensor_plugin), i) == instance
        if ours and int32_at(pointer_at(m + at.m_sensor_type), i) == at.sensor_plugin:
            name = pointer_at(m + at.m_names) + int32_at(pointer_at(m + at.m_name_sensoradr), i)
            slot = sensor_slot(name)
            if slot < 0:
                return SENSOR_NAME
            state[slot] = int32_at(pointer_at(m + at.m_sensor_adr), i)
    return FINE


@njit(cache=True)
def complain(fault, joint):
    """Issues the sentence of a fault code as a MuJoCo warning; `joint` is a C string."""
    if fault == NO_JOINT:
        warn("activesuit.jiles_atherton: the model has no joint '%s'; check config joint", joint)
    elif fault == JOINT_TYPE:
        warn("activesuit.jiles_atherton: joint '%s' is not a hinge or a slide", joint)
    elif fault == PARAMETER:
        warn(
            "activesuit.jiles_atherton: joint '%s' needs a finite number for each of "
            "Ms, a, alpha, c, k",
            joint,
        )
    elif fault == NOT_POSITIVE:
        warn("activesuit.jiles_atherton: joint '%s' needs Ms, a and k above 0", joint)
    elif fault == ANGLE_UNIT:
        warn("activesuit.jiles_atherton: joint '%s' needs angle_unit rad or deg", joint)
    elif fault == START:
        warn(
            "activesuit.jiles_atherton: joint '%s' needs finite numbers for start_angle (rad) "
            "and start_torque (N m)",
            joint,
        )
    elif fault == UNCERTIFIED:
        warn(
            "activesuit.jiles_atherton: the parameters of joint '%s' have no certificate (a "
            "motion could meet infinite torque); set allow_uncertified to true to run anyway",
            joint,
        )
    elif fault == SENSOR_NAME:
        warn(
            "activesuit.jiles_atherton: the name of each sensor of joint '%s' must end in "
            "torque, stiffness or energy, which is what it measures",
            joint,
        )
