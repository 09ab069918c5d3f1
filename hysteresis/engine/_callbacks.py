"""The plugins of hysteresis models: their C callbacks, which MuJoCo calls, compiled by numba.

An instance keeps parameters and memory in `mjData.plugin_state`, so they are part of the physics
state: saved, restored, copied and batched by MuJoCo itself. `compute` only reads the memory (it
may run any number of times per step, at trial positions); `advance` commits it once per step.

Each model gets callbacks of its own, compiled with its module of kernels. The functions that run in
every step are inlined, here and in `_configuration`: passing the layout and the arrays, dozens of
numbers, from one compiled function to the next took half as long as computing the torque.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit

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
    A_LIST,
    A_NUMBER,
    A_WORD,
    COMMON_KEYS,
    ENERGY_SENSOR,
    FINE,
    JOINT,
    OFF,
    OPTIONAL,
    POLE,
    STIFFNESS_SENSOR,
    TORQUE_SENSOR,
    Layout,
    complain_of,
    configure,
    connect,
    has_sensors,
    joint_of,
    parts,
    required_size,
    sensor_of,
)

KINDS = {"number": A_NUMBER, "list": A_LIST, "rows": A_LIST, "word": A_WORD}


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


def build(kernels: ModuleType, kinds: tuple[int, ...], words: tuple[bytes, ...], at: Layout) -> Any:
    """Compiles the callbacks of one model (cached on disk per model and native.layout).

    `kinds` has the kinds of the model's own config keys, as `_configuration` numbers them, and
    `words` the allowed words of each key, with blanks between words; empty for numbers.
    """

    @native.callback
    def nstate(m, instance):
        return required_size(kernels, kinds, m, instance, at)

    @native.callback
    def nsensordata(m, instance, sensor):
        return 1

    @native.callback
    def init(m, d, instance):
        fault, ids = connect(m, instance, at)
        if fault[0] == FINE:
            native.set_word(d, instance, ids, at)
            address, size = native.state_of(m, d, instance, at), native.state_size(m, instance, at)
            fault = configure(kernels, kinds, words, m, instance, ids, address, size, at)
        if fault[0] == FINE:
            return 0
        complain_of(kernels, words, m, instance, fault, at)
        return -1

    @native.callback
    def copy(destination, m, source, instance):
        native.set_word(destination, instance, native.word_of(source, instance, at), at)

    @native.callback
    def reset(m, plugin_state, plugin_data, instance):
        size = native.state_size(m, instance, at)
        configure(kernels, kinds, words, m, instance, plugin_data, plugin_state, size, at)

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
            complain_of(kernels, words, m, instance, (POLE, JOINT), at)
        position = suit_side(kernels, p, memory, polynomial, limits, play, fault[0], position)
        angle = within(limits, position)
        if fault[0] != 0 or not math.isfinite(angle):
            return
        if angle != memory[0]:
            # At a pole the torque stays constant, and the flag is set until a reset.
            if not kernels.is_sound(p) or math.isnan(kernels.commit(p, memory, angle)):
                fault[0] = 1.0
                complain_of(kernels, words, m, instance, (POLE, JOINT), at)
                return
        if play.size:
            play[backlash.END] = position

    return nstate, nsensordata, init, copy, reset, compute, advance


def plugin_name(model: type[HysteresisModel]) -> str:
    """Returns the name of a model's plugin in MJCF."""
    return f"activesuit.{model.name.replace('-', '_')}"


def register() -> dict[str, int]:
    """Registers a plugin for each model with MuJoCo, once; returns their slots by plugin name."""
    bare = [model for model in MODELS.values() if not issubclass(model, Wrapper)]
    return {plugin_name(model): _register(model) for model in bare}


@cache
def _register(model: type[HysteresisModel]) -> int:
    own, at = model.config_keys, native.layout(Layout)
    shared = [Path(str(one.__file__)) for one in (backlash, viscoelastic, polynomial)]
    files = [*shared, *Path(__file__).parent.rglob("*.py")]
    return native.register_plugin(
        plugin_name(model),
        [*COMMON_KEYS, *(key.name for key in own)],
        lambda: build(
            model.kernels,
            tuple(KINDS[key.kind] + OPTIONAL * key.optional for key in own),
            tuple(" ".join(key.words).encode() for key in own),
            at._replace(stamp=stamp_of(model.kernels, files)),
        ),
        native.STAGE_POS,
        sensors=True,
    )
