"""Reading an instance's MJCF config into its state, and saying what is wrong with it."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math

from numba import njit

from .. import _jiles_atherton_kernels as kernels
from ._memory import (
    character_at,
    doubles,
    ends_with,
    equals,
    int32_at,
    name2id,
    parse_number,
    pointer_at,
    warn,
)
from ._state import (
    ALPHA,
    ANGLE,
    BITS,
    ENERGY_SENSOR,
    FAULT,
    LARGEST,
    LOSS,
    MS,
    STEP_LIMIT,
    STIFFNESS_SENSOR,
    TORQUE,
    TORQUE_SENSOR,
    A,
    C,
    K,
    joint_of,
    sensor_of,
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
START, FLAG, UNCERTIFIED, FAR_START, SENSOR_NAME, TOO_LARGE, SENSOR_TWICE = 6, 7, 8, 9, 10, 11, 12

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
def sensor_kind(name):
    """Returns what a sensor measures, as its name says, or -1."""
    if ends_with(name, b"torque"):
        return TORQUE_SENSOR
    if ends_with(name, b"stiffness"):
        return STIFFNESS_SENSOR
    if ends_with(name, b"energy"):
        return ENERGY_SENSOR
    return -1


@njit(cache=True)
def connect(m, instance, at):
    """Returns (fault, packed numbers of the joint and of this instance's sensors)."""
    if max(pointer_at(m + at.m_njnt), pointer_at(m + at.m_nsensor)) >= LARGEST:
        return TOO_LARGE, 0
    wires = name2id(m, at.object_joint, config(m, instance, JOINT, at))
    if wires < 0:
        return NO_JOINT, 0
    joint_type = int32_at(pointer_at(m + at.m_jnt_type), wires)
    if joint_type not in (at.joint_slide, at.joint_hinge):
        return JOINT_TYPE, 0
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
def stored_energy(state, angle, torque):
    """Returns what a motion from here could still get back of the path part of the work [J]."""
    return kernels.recoverable_energy(
        angle, torque, state[MS], state[A], state[ALPHA], state[C], state[K], state[STEP_LIMIT]
    )


@njit(cache=True)
def configure(m, instance, wires, state, at):
    """Fills the state from the config; returns a fault code for `complain`, FINE if it could."""
    fault = read_parameters(m, instance, state, at)
    if fault == FINE:
        fault = read_start(m, instance, wires, state, at)
    if fault == FINE:
        fault = judge(m, instance, state, at)
    state[LOSS] = stored_energy(state, state[ANGLE], state[TORQUE]) if fault == FINE else 0.0
    state[FAULT] = fault != FINE
    return fault


@njit(cache=True)
def read_parameters(m, instance, state, at):
    """Reads Ms, a, alpha, c, k and turns them into radians."""
    for i in range(5):
        value, number = parse_number(config(m, instance, FIRST_PARAMETER + i, at))
        if not number:
            return PARAMETER
        state[MS + i] = value
    if not (state[MS] > 0 and state[A] > 0 and state[K] > 0):
        return NOT_POSITIVE
    unit = config(m, instance, UNIT, at)
    if equals(unit, b"deg"):
        state[A] *= DEGREE
        state[ALPHA] *= DEGREE
        state[K] *= DEGREE
    elif not equals(unit, b"rad"):
        return ANGLE_UNIT
    state[STEP_LIMIT] = kernels.field_step_limit(
        state[MS], state[A], state[ALPHA], state[C], state[K]
    )
    return FINE


@njit(cache=True)
def read_start(m, instance, wires, state, at):
    """Puts the memory at the start, by default the joint's reference position and no torque."""
    qpos = int32_at(pointer_at(m + at.m_jnt_qposadr), joint_of(wires))
    state[ANGLE] = doubles(pointer_at(m + at.m_qpos0), qpos + 1)[qpos]
    state[TORQUE] = 0.0
    for slot, key in ((ANGLE, START_ANGLE), (TORQUE, START_TORQUE)):
        text = config(m, instance, key, at)
        if character_at(text) != 0:
            value, number = parse_number(text)
            if not number:
                return START
            state[slot] = value
    return FINE


@njit(cache=True)
def judge(m, instance, state, at):
    """Refuses parameters without a certificate, and starts outside it, unless told otherwise."""
    flag = config(m, instance, ALLOW, at)
    if equals(flag, b"true"):
        return FINE
    if character_at(flag) != 0 and not equals(flag, b"false"):
        return FLAG
    margin, bound = kernels.certificate(state[MS], state[A], state[ALPHA], state[C], state[K])
    if not (margin > 0 and state[C] >= 1):
        return UNCERTIFIED
    man = kernels.anhysteretic(state[ANGLE], state[TORQUE], state[MS], state[A], state[ALPHA])
    return FINE if abs(state[TORQUE] - man) <= bound else FAR_START


@njit(cache=True)
def complain(fault, joint):
    """Issues the sentence of a fault code as a MuJoCo warning; `joint` is a C string."""
    if fault == NO_JOINT:
        warn(
            "activesuit.jiles_atherton: the model has no joint '%s'; check config joint, and "
            "attach hysteresis after a spec got its name prefix",
            joint,
        )
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
    elif fault == FLAG:
        warn(
            "activesuit.jiles_atherton: joint '%s': allow_uncertified must be true or false", joint
        )
    elif fault == FAR_START:
        warn(
            "activesuit.jiles_atherton: joint '%s' starts too far from its anhysteretic torque for "
            "the certificate; change start_angle or start_torque",
            joint,
        )
    elif fault == SENSOR_TWICE:
        warn("activesuit.jiles_atherton: two sensors of joint '%s' measure the same", joint)
    elif fault == TOO_LARGE:
        warn("activesuit.jiles_atherton: the model of joint '%s' has too many parts", joint)
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
