"""Sets a bushing up from its MJCF config: its two sites, sensors and parameters."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

from typing import NamedTuple

import numpy as np
from numba import njit

from ...hysteresis.engine.native import (
    FOUND,
    UNKNOWN,
    config,
    count_words,
    doubles,
    int32_at,
    name2id,
    pack_sensors,
    packed,
    parse_numbers,
    pointer_at,
)
from ._bushing_kernels import OFFSET

PLUGIN_NAME = "activesuit.bushing"
# Config keys in the order in which MuJoCo stores their values; the numeric ones come last, in the
# order of the parameter vector.
KEYS = (
    "limb",
    "exo",
    "stiffness",
    "rotational_stiffness",
    "damping",
    "rotational_damping",
    "offset",
)
FIRST_NUMBERS = 2
LARGEST_OFFSET = 0.1  # m

# Five numbers of 12 bits in one pointer-sized word, counting from 1; 0 is none.
BITS, LARGEST = 12, 2**12 - 1
WIDTH = np.int64(BITS)
SENSORS = b"force torque energy"  # endings of the names of sensors, from `FORCE_SENSOR` on
LIMB, EXO = range(2)
FORCE_SENSOR, TORQUE_SENSOR, ENERGY_SENSOR = map(np.int64, (2, 3, 4))

# A fault is a reason and the config key it is about, LIMB where it is about the instance.
FINE, NO_SITE, SAME_BODY, NOT_STIFFNESS, NOT_OFFSET, SENSOR_NAME, SENSOR_TWICE, TOO_LARGE = range(8)
SENTENCES = (
    b"",
    b"the model has no such site; name one, and attach bushings after a spec got its name prefix",
    b"it is on the same body as the limb site; name one on another",
    b"give three finite numbers of at least 0",
    b"give three finite numbers from -0.1 to 0.1 m",
    b"the name of each of its sensors must end in force, torque or energy, which is what it "
    b"measures",
    b"two of its sensors measure the same; leave one out",
    b"the model has more than 4094 sites or sensors; make it smaller",
)


class Layout(NamedTuple):
    """The fields of mjModel (m_) and mjData (d_) that a bushing touches, and values of enums."""

    m_nsite: int
    m_nsensor: int
    m_body_parentid: int
    m_body_rootid: int
    m_body_dofnum: int
    m_body_dofadr: int
    m_dof_parentid: int
    m_site_bodyid: int
    m_sensor_type: int
    m_sensor_plugin: int
    m_sensor_adr: int
    m_plugin: int
    m_plugin_stateadr: int
    m_plugin_attr: int
    m_plugin_attradr: int
    m_names: int
    m_name_sensoradr: int
    d_qfrc_passive: int
    d_site_xpos: int
    d_site_xmat: int
    d_subtree_com: int
    d_cdof: int
    d_cvel: int
    d_sensordata: int
    d_plugin_state: int
    d_plugin_data: int
    mjOBJ_SITE: int
    mjSENS_PLUGIN: int
    mjPLUGIN_PASSIVE: int


@njit(inline="always")
def number_of(ids, kind):
    """Returns the number of a site or sensor, or -1."""
    return packed(ids, kind, WIDTH)


@njit(cache=True)
def connect(m, instance, at):
    """Returns (fault, packed ids of the two sites and this instance's sensors)."""
    if max(pointer_at(m + at.m_nsite), pointer_at(m + at.m_nsensor)) >= LARGEST:
        return (TOO_LARGE, LIMB), 0
    ids = 0
    for end in (LIMB, EXO):
        site = name2id(m, at.mjOBJ_SITE, config(m, instance, end, at))
        if site < 0:
            return (NO_SITE, end), 0
        ids |= (site + 1) << (BITS * end)
    bodies = pointer_at(m + at.m_site_bodyid)
    if int32_at(bodies, number_of(ids, LIMB)) == int32_at(bodies, number_of(ids, EXO)):
        return (SAME_BODY, EXO), 0
    outcome, ids = pack_sensors(m, instance, ids, FORCE_SENSOR, WIDTH, SENSORS, at)
    if outcome != FOUND:
        return (SENSOR_NAME if outcome == UNKNOWN else SENSOR_TWICE, LIMB), 0
    return (FINE, LIMB), ids


@njit(cache=True)
def configure(m, instance, address, at):
    """Fills the parameters at `address` from the config; missing ones are 0."""
    for key in range(FIRST_NUMBERS, len(KEYS)):
        first = 3 * (key - FIRST_NUMBERS)
        values = doubles(address + 8 * first, 3)
        values[:] = 0.0
        text = config(m, instance, key, at)
        count = parse_numbers(text, values)
        if count_words(text) > 0 and count != 3:
            return NOT_OFFSET if first == OFFSET else NOT_STIFFNESS, key
        for i in range(3):
            if first == OFFSET and not abs(values[i]) <= LARGEST_OFFSET:
                return NOT_OFFSET, key
            if first != OFFSET and not values[i] >= 0:
                return NOT_STIFFNESS, key
    return FINE, LIMB
