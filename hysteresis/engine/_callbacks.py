"""What MuJoCo calls: the Jiles-Atherton joint as an engine plugin, compiled to C callbacks.

An instance keeps parameters and memory in `mjData.plugin_state`, so they are part of the physics
state: saved, restored, copied and batched by MuJoCo itself. `compute` only reads the memory (it
may run any number of times per step, at trial positions); `advance` commits it once per step.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from typing import Any

from numba import cfunc, njit, types

from .. import _jiles_atherton_kernels as kernels
from ._configuration import FINE, JOINT, complain, config, configure, connect, stored_energy
from ._layout import Layout
from ._memory import doubles, int32_at, pointer_at, warn
from ._state import (
    ALPHA,
    ANGLE,
    ENERGY_SENSOR,
    FAULT,
    LOSS,
    MS,
    STATE_SIZE,
    STEP_LIMIT,
    STIFFNESS_SENSOR,
    TORQUE,
    TORQUE_SENSOR,
    A,
    C,
    K,
    joint_of,
    sensor_of,
    set_wires,
    state_of,
    wires_of,
)


@njit(cache=True)
def move(state, angle):
    """Returns torque and loss after a motion from the committed memory to `angle`."""
    return kernels.advance(
        state[ANGLE],
        state[TORQUE],
        angle,
        state[MS],
        state[A],
        state[ALPHA],
        state[C],
        state[K],
        state[STEP_LIMIT],
    )


@njit(cache=True)
def angle_of(m, d, joint, at):
    """Returns the joint's position."""
    qpos = int32_at(pointer_at(m + at.m_jnt_qposadr), joint)
    return doubles(pointer_at(d + at.d_qpos), qpos + 1)[qpos]


@njit(cache=True)
def evaluate(m, d, instance, capability, at):
    """Adds the torque at the current position, or writes the sensors; changes no memory."""
    state = state_of(m, d, instance, at)
    wires = wires_of(d, instance, at)
    joint = joint_of(wires)
    angle = angle_of(m, d, joint, at)
    torque, loss = state[TORQUE], 0.0
    if state[FAULT] == 0:
        moved, loss = move(state, angle)
        if math.isnan(moved):
            angle, loss = state[ANGLE], 0.0
        else:
            torque = moved
    dof = int32_at(pointer_at(m + at.m_jnt_dofadr), joint)
    if capability == at.passive:
        doubles(pointer_at(d + at.d_qfrc_passive), dof + 1)[dof] -= torque
        return
    if sensor_of(wires, TORQUE_SENSOR) >= 0:
        write_sensor(m, d, sensor_of(wires, TORQUE_SENSOR), -torque, at)
    if sensor_of(wires, STIFFNESS_SENSOR) >= 0:
        velocity = doubles(pointer_at(d + at.d_qvel), dof + 1)[dof]
        stiffness = kernels.tangent_stiffness(
            angle,
            torque,
            math.copysign(1.0, velocity),
            state[MS],
            state[A],
            state[ALPHA],
            state[C],
            state[K],
        )
        write_sensor(m, d, sensor_of(wires, STIFFNESS_SENSOR), stiffness, at)
    if sensor_of(wires, ENERGY_SENSOR) >= 0:
        energy = state[LOSS] + loss - stored_energy(state, angle, torque)
        write_sensor(m, d, sensor_of(wires, ENERGY_SENSOR), energy, at)


@njit(cache=True)
def write_sensor(m, d, sensor, value, at):
    """Writes the value of a sensor."""
    address = int32_at(pointer_at(m + at.m_sensor_adr), sensor)
    doubles(pointer_at(d + at.d_sensordata), address + 1)[address] = value


@njit(cache=True)
def commit(m, d, instance, at):
    """Moves the memory to the new position; at a pole the torque is held and the fault flag set."""
    state = state_of(m, d, instance, at)
    angle = angle_of(m, d, joint_of(wires_of(d, instance, at)), at)
    if state[FAULT] != 0 or angle == state[ANGLE] or not math.isfinite(angle):
        return
    torque, loss = move(state, angle)
    if math.isnan(torque):
        state[FAULT] = 1.0
        warn(
            "activesuit.jiles_atherton: the torque of joint '%s' met its pole; it is held at its "
            "last valid value, and the fault flag is set",
            config(m, instance, JOINT, at),
        )
        return
    state[ANGLE], state[TORQUE] = angle, torque
    state[LOSS] += loss


def build(at: Layout) -> dict[str, Any]:
    """Compiles the callbacks for one layout of MuJoCo's structs (cached on disk per layout)."""

    @cfunc(types.int32(types.intp, types.int32), cache=True)
    def nstate(m, instance):
        return STATE_SIZE

    @cfunc(types.int32(types.intp, types.int32, types.int32), cache=True)
    def nsensordata(m, instance, sensor):
        return 1

    @cfunc(types.int32(types.intp, types.intp, types.int32), cache=True)
    def init(m, d, instance):
        fault, wires = connect(m, instance, at)
        if fault == FINE:
            set_wires(d, instance, wires, at)
            fault = configure(m, instance, wires, state_of(m, d, instance, at), at)
        if fault == FINE:
            return 0
        complain(fault, config(m, instance, JOINT, at))
        return -1

    @cfunc(types.void(types.intp, types.intp, types.intp, types.int32), cache=True)
    def copy(destination, m, source, instance):
        set_wires(destination, instance, wires_of(source, instance, at), at)

    @cfunc(types.void(types.intp, types.intp, types.intp, types.int32), cache=True)
    def reset(m, plugin_state, plugin_data, instance):
        configure(m, instance, plugin_data, doubles(plugin_state, STATE_SIZE), at)

    @cfunc(types.void(types.intp, types.intp, types.int32, types.int32), cache=True)
    def compute(m, d, instance, capability):
        evaluate(m, d, instance, capability, at)

    @cfunc(types.void(types.intp, types.intp, types.int32), cache=True)
    def advance(m, d, instance):
        commit(m, d, instance, at)

    callbacks = (nstate, nsensordata, init, copy, reset, compute, advance)
    return {callback.__name__: callback for callback in callbacks}
