"""A bushing as an engine plugin of MuJoCo, compiled to C callbacks.

An instance keeps its parameters in `mjData.plugin_state`, so they are part of the physics state and
may differ between the simulations of a batch. It has no memory: `compute` changes no state.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

from typing import Any

from numba import njit

from ...hysteresis.engine.native import (
    callback,
    complain,
    doubles,
    int32_at,
    pointer_at,
    sensor_kind,
    sensor_name,
    sensor_values,
    set_word,
    state_of,
    word_of,
)
from ._bushing_configuration import (
    ENERGY_SENSOR,
    EXO,
    FINE,
    FORCE_SENSOR,
    LIMB,
    SENSORS,
    SENTENCES,
    TORQUE_SENSOR,
    Layout,
    configure,
    connect,
    number_of,
)
from ._bushing_kernels import PARAMETER_SIZE, add, cross, dot, load, out_of, scale, subtract, triple


@njit(inline="always")
def site_frame(d, site, at):
    """Returns position and axes of a site, as views."""
    position = doubles(pointer_at(d + at.d_site_xpos) + 24 * site, 3)
    return position, doubles(pointer_at(d + at.d_site_xmat) + 72 * site, 9)


@njit(cache=True)
def lever(m, d, body, point, at):
    """Returns the vector to a point from the reference point of a body's motion (cvel, cdof)."""
    root = int32_at(pointer_at(m + at.m_body_rootid), body)
    return subtract(point, triple(doubles(pointer_at(d + at.d_subtree_com) + 24 * root, 3), 0))


@njit(cache=True)
def motion_at(m, d, body, point, at):
    """Returns angular velocity of a body and velocity of its material at a point of the world."""
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
    limb_site, exo_site = number_of(ids, LIMB), number_of(ids, EXO)
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
    write(m, d, number_of(ids, FORCE_SENSOR), force, at)
    write(m, d, number_of(ids, TORQUE_SENSOR), torque, at)
    write(m, d, number_of(ids, ENERGY_SENSOR), (energy,), at)


@njit(inline="always")
def write(m, d, sensor, values, at):
    """Writes the values of a sensor, if there is one."""
    if sensor >= 0:
        data = sensor_values(m, d, sensor, len(values), at)
        for i in range(len(values)):
            data[i] = values[i]


def build(at: Layout) -> Any:
    """Compiles the callbacks for one layout of MuJoCo's structs (cached on disk per layout)."""

    @callback
    def nstate(m, instance):
        return PARAMETER_SIZE

    @callback
    def nsensordata(m, instance, sensor):
        kind = FORCE_SENSOR + sensor_kind(sensor_name(m, sensor, at), SENSORS)
        return 1 if kind == ENERGY_SENSOR else 3

    @callback
    def init(m, d, instance):
        fault, ids = connect(m, instance, at)
        if fault[0] == FINE:
            set_word(d, instance, ids, at)
            fault = configure(m, instance, state_of(m, d, instance, at), at)
        if fault[0] == FINE:
            return 0
        complain(m, instance, b"limb site", LIMB, fault[1], SENTENCES[fault[0]], at)
        return -1

    @callback
    def copy(destination, m, source, instance):
        set_word(destination, instance, word_of(source, instance, at), at)

    @callback
    def reset(m, plugin_state, plugin_data, instance):
        configure(m, instance, plugin_state, at)

    @callback
    def compute(m, d, instance, capability):
        evaluate(m, d, instance, capability, at)

    return nstate, nsensordata, init, copy, reset, compute
