"""What an instance keeps in `mjData.plugin_state`: addresses, parameters (radians), memory."""

from numba import njit

from ._memory import doubles, int32_at, pointer_at

QPOS, DOF, TORQUE_SENSOR, STIFFNESS_SENSOR, ENERGY_SENSOR = 0, 1, 2, 3, 4
MS, A, ALPHA, C, K, STEP_LIMIT = 5, 6, 7, 8, 9, 10
ANGLE, TORQUE, LOSS, FAULT = 11, 12, 13, 14
STATE_SIZE = 15


@njit(cache=True)
def state_of(m, d, instance, at):
    """Returns the view of an instance's state in mjData `d`."""
    address = int32_at(pointer_at(m + at.m_plugin_stateadr), instance)
    return doubles(pointer_at(d + at.d_plugin_state) + 8 * address, STATE_SIZE)
