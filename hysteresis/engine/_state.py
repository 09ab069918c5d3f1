"""Places of an instance's state and ids in mjData, and of the fields of MuJoCo that it reads.

`mjData.plugin_state` holds the physical state: fault flag, memory, parameters (radians), the
elastic polynomial, the range, the viscoelastic part and the play. They are saved, copied and
batched with the rest of the state, and may differ between simulations. `mjData.plugin_data` holds
what follows from the MuJoCo model: the ids of the joint and of the sensors, packed into one
integer. A state may be set on any MuJoCo model: the ids always fit the model at hand, and so do the
sizes, which come from mjModel.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from ...kernels import inner
from ..around.backlash_kernels import SIZE as PLAY_SIZE
from ..around.viscoelastic_kernels import SIZE
from .native import doubles, packed

FAULT, MEMORY = 0, 1
OFF = 2.0  # flag of an instance that is taken off: it gives no torque
POLYNOMIAL_LIMIT = 6  # number of coefficients, those of angle^0 to angle^5

# A pointer-sized word holds four ids of 14 bits, the length of the polynomial (3 bits), whether the
# torque is constant outside a range, whether there is a viscoelastic part and whether there is play
# (1 bit each). Sensors count from 1; 0 is none.
BITS, LARGEST = 14, 2**14 - 1
WIDTH = np.int64(BITS)
SENSORS = b"torque stiffness energy"  # endings of the names of sensors, from `TORQUE_SENSOR` on
TORQUE_SENSOR, STIFFNESS_SENSOR, ENERGY_SENSOR = map(np.int64, (1, 2, 3))
POLYNOMIAL_SHIFT, HELD_SHIFT, VISCOELASTIC_SHIFT = 4 * BITS, 4 * BITS + 3, 4 * BITS + 4
PLAY_SHIFT = 4 * BITS + 5


class Layout(NamedTuple):
    """Byte offsets of fields in mjModel (m_) and mjData (d_), and values of some enums.

    `stamp` distinguishes versions of a model's kernels and of the engine, so that numba's cache
    does not give back machine code of an older version.
    """

    m_opt__timestep: int
    m_nsensor: int
    m_njnt: int
    m_jnt_type: int
    m_jnt_qposadr: int
    m_jnt_dofadr: int
    m_qpos0: int
    m_sensor_type: int
    m_sensor_plugin: int
    m_sensor_adr: int
    m_plugin: int
    m_plugin_stateadr: int
    m_plugin_statenum: int
    m_plugin_attr: int
    m_plugin_attradr: int
    m_names: int
    m_name_sensoradr: int
    d_qpos: int
    d_qvel: int
    d_qfrc_passive: int
    d_sensordata: int
    d_plugin_state: int
    d_plugin_data: int
    mjOBJ_JOINT: int
    mjJNT_SLIDE: int
    mjJNT_HINGE: int
    mjSENS_PLUGIN: int
    mjPLUGIN_PASSIVE: int
    stamp: int = 0


@njit(inline="always")
def parts(kernels, ids, address, size):
    """Returns views of the parts of a state.

    They are fault flag, memory, parameters, polynomial, range, viscoelastic part, play.
    """
    polynomial, limits = (ids >> POLYNOMIAL_SHIFT) & 7, 2 * ((ids >> HELD_SHIFT) & 1)
    rate, play = SIZE * ((ids >> VISCOELASTIC_SHIFT) & 1), PLAY_SIZE * (ids >> PLAY_SHIFT)
    own = size - MEMORY - polynomial - limits - rate - play
    memory = kernels.memory_size(own)
    start = address + 8 * MEMORY
    end = start + 8 * own
    return (
        doubles(address, 1),
        doubles(start, memory),
        doubles(start + 8 * memory, own - memory),
        doubles(end, polynomial),
        doubles(end + 8 * polynomial, limits),
        doubles(end + 8 * (polynomial + limits), rate),
        doubles(end + 8 * (polynomial + limits + rate), play),
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
    return packed(ids, kind, WIDTH)
