"""Where an instance keeps what it needs.

`mjData.plugin_state` holds what is physics: fault flag, memory, parameters (radians), the elastic
polynomial and the range. They are saved, copied and batched with the rest of the state, and may
differ between simulations. `mjData.plugin_data` holds what follows from the model: which hysteresis
model it is, the joint and the sensors, by number. A state may be set on any MuJoCo model; these
numbers always fit the one at hand, and so do the sizes, which come from mjModel.
"""

from numba import njit

from ._models import PRANDTL_ISHLINSKII, sizes
from .native._memory import doubles, int32_at, pointer_at, store_pointer

FAULT, MEMORY = 0, 1
POLYNOMIAL_LIMIT = 6  # coefficients, of angle^0 to angle^5

# Four numbers of 14 bits, the model (2 bits), the length of the polynomial (3) and whether the
# torque is held outside a range (1) in one pointer-sized word. Sensors count from 1; 0 is none.
BITS, LARGEST = 14, 2**14 - 1
TORQUE_SENSOR, STIFFNESS_SENSOR, ENERGY_SENSOR = 1, 2, 3
MODEL_SHIFT, POLYNOMIAL_SHIFT, HELD_SHIFT = 4 * BITS, 4 * BITS + 2, 4 * BITS + 5


@njit(cache=True)
def state_size(kind, count):
    """Returns how many numbers an instance keeps in plugin_state, without polynomial and range."""
    memory, parameters = sizes(kind, count)
    return MEMORY + memory + parameters


@njit(inline="always")
def count_in(kind, size):
    """Returns the number of thresholds or segments of an instance with a state of that size."""
    if kind == PRANDTL_ISHLINSKII:
        return (size - state_size(kind, 0)) // 3
    count = 0
    while state_size(kind, count) < size and state_size(kind, count + 1) > state_size(kind, count):
        count += 1
    return count


@njit(inline="always")
def kind_of(wires):
    """Returns the number of the model, as in `_models`."""
    return (wires >> MODEL_SHIFT) & 3


@njit(inline="always")
def address_of(m, d, instance, at):
    """Returns the address of an instance's state in mjData `d`, and its size."""
    address = int32_at(pointer_at(m + at.m_plugin_stateadr), instance)
    size = int32_at(pointer_at(m + at.m_plugin_statenum), instance)
    return pointer_at(d + at.d_plugin_state) + 8 * address, size


@njit(inline="always")
def parts(wires, address, size):
    """Returns views of the parts of a state: fault flag, memory, parameters, polynomial, range."""
    kind, polynomial = kind_of(wires), (wires >> POLYNOMIAL_SHIFT) & 7
    limits = 2 * (wires >> HELD_SHIFT)
    memory, parameters = sizes(kind, count_in(kind, size - polynomial - limits))
    start = address + 8 * MEMORY
    end = start + 8 * (memory + parameters)
    return (
        doubles(address, 1),
        doubles(start, memory),
        doubles(start + 8 * memory, parameters),
        doubles(end, polynomial),
        doubles(end + 8 * polynomial, limits),
    )


@njit(cache=True)
def wires_of(d, instance, at):
    """Returns the packed numbers of an instance."""
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
def has_sensors(wires):
    """Returns whether any sensor is wired."""
    return (wires >> BITS) & (2 ** (3 * BITS) - 1) != 0


@njit(inline="always")
def sensor_of(wires, kind):
    """Returns the number of the sensor of a kind, or -1."""
    return ((wires >> (BITS * kind)) & LARGEST) - 1
