"""The plugins of hysteresis models: their C callbacks, compiled by numba where they run in steps.

An instance keeps parameters and memory in `mjData.plugin_state`, so they are part of the physics
state: saved, restored, copied and batched by MuJoCo itself. `compute` only reads the memory (it
may run any number of times per step, at trial positions); `advance` commits it once per step.

Each model gets callbacks of its own, compiled with its module of kernels. The functions that run in
every step are inlined: passing the layout and the arrays, dozens of numbers, from one compiled
function to the next took half as long as computing the torque.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from collections import namedtuple
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit

from ...kernels import inner
from .. import polynomial
from ..around import Wrapper
from ..around import backlash_kernels as backlash
from ..around import viscoelastic_kernels as viscoelastic
from ..around.backlash_kernels import within
from ..polynomial import slope_of, value_of
from ..protocol import HysteresisModel, stamp_of
from ..registry import MODELS
from . import native
from ._configuration import (
    BITS,
    HELD_SHIFT,
    LARGEST,
    MEMORY,
    OFF,
    PLAY_SHIFT,
    POLYNOMIAL_SHIFT,
    VISCOELASTIC_SHIFT,
    begun,
    connect,
    key_names,
    model_of,
    reference_of,
    size_of,
)

# Numbers of NumPy: numba would compile functions anew for each number of Python.
WIDTH = np.int64(BITS)
TORQUE_SENSOR, STIFFNESS_SENSOR, ENERGY_SENSOR = map(np.int64, (1, 2, 3))
POLE = (
    "activesuit: the torque of joint '%s' met a pole (or the parameters in its state are out of "
    "range); the torque stays at its last valid value, and the fault flag is set"
)
Layout = namedtuple(
    "Layout",
    "m_opt__timestep m_jnt_qposadr m_jnt_dofadr m_sensor_adr m_plugin_stateadr m_plugin_statenum "
    "m_names m_name_jntadr d_qpos d_qvel d_qfrc_passive d_sensordata d_plugin_state d_plugin_data "
    "mjPLUGIN_PASSIVE stamp",
    defaults=(0,),
)
"""Byte offsets of fields in mjModel (m_) and mjData (d_), and a value of an enum.

`stamp` distinguishes versions of a model's kernels and of the engine, so that numba's cache does
not give back machine code of an older version.
"""


@njit(inline="always")
def parts(kernels, ids, address, size):
    """Returns views of a state's flag, memory, parameters, polynomial, range, rate and play."""
    polynomial, limits = (ids >> POLYNOMIAL_SHIFT) & 7, 2 * ((ids >> HELD_SHIFT) & 1)
    rate = viscoelastic.SIZE * ((ids >> VISCOELASTIC_SHIFT) & 1)
    play = backlash.SIZE * (ids >> PLAY_SHIFT)
    own = size - MEMORY - polynomial - limits - rate - play
    memory = kernels.memory_size(own)
    start = address + 8 * MEMORY
    end = start + 8 * own
    return (
        native.doubles(address, 1),
        native.doubles(start, memory),
        native.doubles(start + 8 * memory, own - memory),
        native.doubles(end, polynomial),
        native.doubles(end + 8 * polynomial, limits),
        native.doubles(end + 8 * (polynomial + limits), rate),
        native.doubles(end + 8 * (polynomial + limits + rate), play),
    )


@inner(cache=False)
def joint_of(ids):
    """Returns the id of the joint."""
    return ids & LARGEST


@inner(cache=False)
def has_sensors(ids):
    """Returns whether there is any sensor."""
    return (ids >> BITS) & (2 ** (3 * BITS) - 1) != 0


@inner(cache=False)
def sensor_of(ids, kind):
    """Returns the id of the sensor of a kind, or -1."""
    return native.packed(ids, kind, WIDTH)


@inner(cache=False)
def warn_of_pole(m, joint, at):
    """Issues a MuJoCo warning that the torque on a joint has met a pole."""
    name = native.int32_at(native.pointer_at(m + at.m_name_jntadr), joint)
    native.warn(POLE, native.pointer_at(m + at.m_names) + name)


@njit(inline="always")
def angle_of(m, d, joint, at):
    """Returns the joint's position."""
    qpos = native.int32_at(native.pointer_at(m + at.m_jnt_qposadr), joint)
    return native.doubles(native.pointer_at(d + at.d_qpos), qpos + 1)[qpos]


@njit(inline="always")
def suit_side(kernels, p, memory, polynomial, limits, play, fault, angle):
    """Returns the angle of the suit's side at a trial angle, or the angle itself without a gap.

    In a state that is not sound the suit's side stays at its last angle.
    """
    if play.size == 0:
        return angle
    sound = backlash.is_sound(play) and kernels.is_sound(p)
    if fault != 0 or not sound or not math.isfinite(angle):
        return play[backlash.END]
    return backlash.end_at(kernels, p, memory, polynomial, limits, play, angle)


@njit(inline="always")
def reached(kernels, p, memory, fault, angle):
    """Returns (angle, torque, loss) at a trial angle, or of the memory where the torque is NaN."""
    # The angles are equal after every step, when the memory has just been moved there.
    if angle != memory[0] and fault == 0 and kernels.is_sound(p):
        torque, loss = kernels.move(p, memory, angle)[:2]
        if not math.isnan(torque):
            return angle, torque, loss
    return memory[0], memory[1], 0.0


@njit(inline="always")
def clear(m, d, ids, at):
    """Writes 0 to the sensors."""
    for kind in (TORQUE_SENSOR, STIFFNESS_SENSOR, ENERGY_SENSOR):
        if sensor_of(ids, kind) >= 0:
            native.sensor_values(m, d, sensor_of(ids, kind), 1, at)[0] = 0.0


@njit(inline="always")
def evaluate(kernels, m, d, instance, capability, at):
    """Adds the torque at the current position, or writes the sensors; changes no memory."""
    ids = native.word_of(d, instance, at)
    if capability != at.mjPLUGIN_PASSIVE and not has_sensors(ids):
        return
    joint = joint_of(ids)
    address, size = native.state_of(m, d, instance, at), native.state_size(m, instance, at)
    fault, memory, p, polynomial, limits, rate, play = parts(kernels, ids, address, size)
    if fault[0] == OFF:
        if capability != at.mjPLUGIN_PASSIVE:
            clear(m, d, ids, at)
        return
    joint_angle = angle_of(m, d, joint, at)
    position = suit_side(kernels, p, memory, polynomial, limits, play, fault[0], joint_angle)
    inside = within(limits, position)
    angle, torque, loss = reached(kernels, p, memory, fault[0], inside)
    if angle != inside:  # the torque at the position is NaN
        position = angle
    total = torque + value_of(polynomial, position)
    dof = native.int32_at(native.pointer_at(m + at.m_jnt_dofadr), joint)
    if rate.size and viscoelastic.is_sound(rate):
        velocity = native.doubles(native.pointer_at(d + at.d_qvel), dof + 1)[dof]
        total += viscoelastic.torque_at(rate, joint_angle, velocity)
    if capability == at.mjPLUGIN_PASSIVE:
        native.doubles(native.pointer_at(d + at.d_qfrc_passive), dof + 1)[dof] -= total
        return
    if sensor_of(ids, TORQUE_SENSOR) >= 0:
        native.sensor_values(m, d, sensor_of(ids, TORQUE_SENSOR), 1, at)[0] = -total
    if not kernels.is_sound(p):
        return
    if sensor_of(ids, STIFFNESS_SENSOR) >= 0:
        velocity = native.doubles(native.pointer_at(d + at.d_qvel), dof + 1)[dof]
        delta = math.copysign(1.0, velocity)
        slope = slope_of(polynomial, position)
        if limits.size == 0 or limits[0] < position < limits[1]:
            slope += kernels.stiffness(p, memory, angle, torque, delta)
        held = torque + value_of(polynomial, position)
        free = play.size > 0 and backlash.is_free(held, play, position, joint_angle, delta)
        shown = 0.0 if free else slope
        native.sensor_values(m, d, sensor_of(ids, STIFFNESS_SENSOR), 1, at)[0] = shown
    if sensor_of(ids, ENERGY_SENSOR) >= 0:
        lost = kernels.dissipated(p, memory, angle, torque, loss)
        if rate.size:
            lost += rate[viscoelastic.LOSS]
        native.sensor_values(m, d, sensor_of(ids, ENERGY_SENSOR), 1, at)[0] = lost


def build(model: type[HysteresisModel], at: Layout) -> Any:
    """Returns the functions of a model's plugin (compiled ones are cached per model and layout)."""
    kernels = model.kernels

    def nstate(instance):
        return size_of(model_of(model, instance.raw))

    def init(instance):
        return connect(model, instance)

    def reset(instance, state, word):
        state[0] = 1.0  # unless the config is sound
        state[:] = begun(model, instance.raw, reference_of(instance, word))

    @native.callback
    def compute(m, d, instance, capability):
        evaluate(kernels, m, d, instance, capability, at)

    @native.callback
    def advance(m, d, instance):
        ids = native.word_of(d, instance, at)
        address, size = native.state_of(m, d, instance, at), native.state_size(m, instance, at)
        fault, memory, p, polynomial, limits, rate, play = parts(kernels, ids, address, size)
        position = angle_of(m, d, joint_of(ids), at)
        sound = play.size == 0 or backlash.is_sound(play)
        if rate.size and fault[0] != OFF and math.isfinite(position):
            if viscoelastic.is_sound(rate):
                viscoelastic.relax(rate, position, native.doubles(m + at.m_opt__timestep, 1)[0])
            else:
                sound = False
        if fault[0] == 0 and not sound:
            fault[0] = 1.0
            warn_of_pole(m, joint_of(ids), at)
        position = suit_side(kernels, p, memory, polynomial, limits, play, fault[0], position)
        angle = within(limits, position)
        if fault[0] != 0 or not math.isfinite(angle):
            return
        if angle != memory[0]:
            # At a pole the torque stays constant, and the flag is set until a reset.
            if not kernels.is_sound(p) or math.isnan(kernels.commit(p, memory, angle)):
                fault[0] = 1.0
                warn_of_pole(m, joint_of(ids), at)
                return
        if play.size:
            play[backlash.END] = position

    return nstate, init, reset, compute, advance


def plugin_name(model: type[HysteresisModel]) -> str:
    """Returns the name of a model's plugin in MJCF."""
    return f"activesuit.{model.name.replace('-', '_')}"


def register() -> dict[str, int]:
    """Registers a plugin for each model with MuJoCo, once; returns their slots by plugin name."""
    bare = [model for model in MODELS.values() if not issubclass(model, Wrapper)]
    return {plugin_name(model): _register(model) for model in bare}


@cache
def _register(model: type[HysteresisModel]) -> int:
    at = native.layout(Layout)
    shared = [Path(str(one.__file__)) for one in (backlash, viscoelastic, polynomial)]
    files = [*shared, *Path(__file__).parent.rglob("*.py")]
    return native.register_plugin(
        plugin_name(model),
        key_names(model),
        lambda: build(model, at._replace(stamp=stamp_of(model.kernels, files))),
        native.STAGE_POS,
        sensors=True,
    )
