"""Where an instance keeps what it needs.

`mjData.plugin_state` holds what is physics: parameters (radians), memory and the fault flag. They
are saved, copied and batched with the rest of the state, and may differ between simulations.
`mjData.plugin_data` holds what follows from the model: the joint and the sensors, by number. A
state may be set on any model; these numbers always fit the model at hand.
"""

from numba import njit

from ._memory import doubles, int32_at, pointer_at, store_pointer

MS, A, ALPHA, C, K, STEP_LIMIT = 0, 1, 2, 3, 4, 5
ANGLE, TORQUE, LOSS, FAULT = 6, 7, 8, 9
STATE_SIZE = 10

# Four numbers of 15 bits in one pointer-sized word. Sensor numbers count from 1; 0 is none.
BITS, LARGEST = 15, 2**15 - 1
TORQUE_SENSOR, STIFFNESS_SENSOR, ENERGY_SENSOR = 1, 2, 3


@njit(cache=True)
def state_of(m, d, instance, at):
    """Returns the view of an instance's state in mjData `d`."""
    address = int32_at(pointer_at(m + at.m_plugin_stateadr), instance)
    return doubles(pointer_at(d + at.d_plugin_state) + 8 * address, STATE_SIZE)


@njit(cache=True)
def wires_of(d, instance, at):
    """Returns the packed numbers of the joint and the sensors of an instance."""
    return pointer_at(pointer_at(d + at.d_plugin_data) + 8 * instance)


@njit(cache=True)
def set_wires(d, instance, wires, at):
    """Stores the packed numbers."""
    store_pointer(pointer_at(d + at.d_plugin_data) + 8 * instance, wires)


@njit(inline="always")
def joint_of(wires):
    """Returns the number of the joint."""
    return wires & LARGEST


@njit(inline="always")
def sensor_of(wires, kind):
    """Returns the number of the sensor of a kind, or -1."""
    return ((wires >> (BITS * kind)) & LARGEST) - 1
