"""What MuJoCo calls: a joint with a hysteresis model as an engine plugin, compiled to C callbacks.

An instance keeps parameters and memory in `mjData.plugin_state`, so they are part of the physics
state: saved, restored, copied and batched by MuJoCo itself. `compute` only reads the memory (it
may run any number of times per step, at trial positions); `advance` commits it once per step.

What runs in every step is inlined, here and in `_models` and `_state`: to hand the layout and the
arrays, dozens of numbers, from one compiled function to the next took half as long as the torque.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from typing import Any

from numba import cfunc, njit, types

from . import _models as models
from ._configuration import configure, connect, required_size, slope_of, value_of
from ._faults import FINE, POLE, complain
from ._state import (
    ENERGY_SENSOR,
    STIFFNESS_SENSOR,
    TORQUE_SENSOR,
    address_of,
    has_sensors,
    joint_of,
    kind_of,
    parts,
    sensor_of,
    set_wires,
    wires_of,
)
from .native._layout import Layout
from .native._memory import doubles, int32_at, pointer_at


@njit(inline="always")
def angle_of(m, d, joint, at):
    """Returns the joint's position."""
    qpos = int32_at(pointer_at(m + at.m_jnt_qposadr), joint)
    return doubles(pointer_at(d + at.d_qpos), qpos + 1)[qpos]


@njit(inline="always")
def within(limits, angle):
    """Returns the angle, or the nearest in the range outside which the torque is held."""
    if limits.size == 0 or math.isnan(angle):
        return angle
    return min(max(angle, limits[0]), limits[1])


@njit(inline="always")
def reached(kind, p, memory, fault, angle):
    """Returns angle, torque and loss at a trial angle; those of the memory if it has no torque."""
    # The angles are equal after every step, when the memory has just been moved there.
    if angle != memory[0] and fault == 0 and models.is_sound(kind, p):
        torque, loss = models.move(kind, p, memory, angle)
        if not math.isnan(torque):
            return angle, torque, loss
    return memory[0], memory[1], 0.0


@njit(inline="always")
def evaluate(m, d, instance, capability, at):
    """Adds the torque at the current position, or writes the sensors; changes no memory."""
    wires = wires_of(d, instance, at)
    if capability != at.passive and not has_sensors(wires):
        return
    kind, joint = kind_of(wires), joint_of(wires)
    address, size = address_of(m, d, instance, at)
    fault, memory, p, polynomial, limits = parts(wires, address, size)
    position = angle_of(m, d, joint, at)
    inside = within(limits, position)
    angle, torque, loss = reached(kind, p, memory, fault[0], inside)
    if angle != inside:  # there is no torque at the position
        position = angle
    total = torque + value_of(polynomial, position)
    dof = int32_at(pointer_at(m + at.m_jnt_dofadr), joint)
    if capability == at.passive:
        doubles(pointer_at(d + at.d_qfrc_passive), dof + 1)[dof] -= total
        return
    if sensor_of(wires, TORQUE_SENSOR) >= 0:
        write_sensor(m, d, sensor_of(wires, TORQUE_SENSOR), -total, at)
    if not models.is_sound(kind, p):
        return
    if sensor_of(wires, STIFFNESS_SENSOR) >= 0:
        velocity = doubles(pointer_at(d + at.d_qvel), dof + 1)[dof]
        delta = math.copysign(1.0, velocity)
        slope = slope_of(polynomial, position)
        if limits.size == 0 or limits[0] < position < limits[1]:
            slope += models.stiffness(kind, p, memory, angle, torque, delta)
        write_sensor(m, d, sensor_of(wires, STIFFNESS_SENSOR), slope, at)
    if sensor_of(wires, ENERGY_SENSOR) >= 0:
        lost = models.dissipated(kind, p, memory, angle, torque, loss)
        write_sensor(m, d, sensor_of(wires, ENERGY_SENSOR), lost, at)


@njit(inline="always")
def write_sensor(m, d, sensor, value, at):
    """Writes the value of a sensor."""
    address = int32_at(pointer_at(m + at.m_sensor_adr), sensor)
    doubles(pointer_at(d + at.d_sensordata), address + 1)[address] = value


@njit(inline="always")
def advance_memory(m, d, instance, at):
    """Moves the memory to the new position; at a pole the torque is held and the fault flag set."""
    wires = wires_of(d, instance, at)
    kind = kind_of(wires)
    address, size = address_of(m, d, instance, at)
    fault, memory, p, _, limits = parts(wires, address, size)
    angle = within(limits, angle_of(m, d, joint_of(wires), at))
    if fault[0] != 0 or angle == memory[0] or not math.isfinite(angle):
        return
    if not models.is_sound(kind, p) or math.isnan(models.commit(kind, p, memory, angle)):
        fault[0] = 1.0
        complain(m, instance, POLE, at)


def build(at: Layout) -> dict[str, Any]:
    """Compiles the callbacks for one layout of MuJoCo's structs (cached on disk per layout)."""

    @cfunc(types.int32(types.intp, types.int32), cache=True)
    def nstate(m, instance):
        return required_size(m, instance, at)

    @cfunc(types.int32(types.intp, types.int32, types.int32), cache=True)
    def nsensordata(m, instance, sensor):
        return 1

    @cfunc(types.int32(types.intp, types.intp, types.int32), cache=True)
    def init(m, d, instance):
        fault, wires = connect(m, instance, at)
        if fault == FINE:
            set_wires(d, instance, wires, at)
            address, size = address_of(m, d, instance, at)
            fault = configure(m, instance, wires, address, size, at)
        if fault == FINE:
            return 0
        complain(m, instance, fault, at)
        return -1

    @cfunc(types.void(types.intp, types.intp, types.intp, types.int32), cache=True)
    def copy(destination, m, source, instance):
        set_wires(destination, instance, wires_of(source, instance, at), at)

    @cfunc(types.void(types.intp, types.intp, types.intp, types.int32), cache=True)
    def reset(m, plugin_state, plugin_data, instance):
        size = int32_at(pointer_at(m + at.m_plugin_statenum), instance)
        configure(m, instance, plugin_data, plugin_state, size, at)

    @cfunc(types.void(types.intp, types.intp, types.int32, types.int32), cache=True)
    def compute(m, d, instance, capability):
        evaluate(m, d, instance, capability, at)

    @cfunc(types.void(types.intp, types.intp, types.int32), cache=True)
    def advance(m, d, instance):
        advance_memory(m, d, instance, at)

    callbacks = (nstate, nsensordata, init, copy, reset, compute, advance)
    return {callback.__name__: callback for callback in callbacks}
