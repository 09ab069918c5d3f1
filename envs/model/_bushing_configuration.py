"""Sets a bushing up from its MJCF config: its two sites, sensors and parameters."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import numpy as np
from numba import njit

from ...hysteresis.engine._faults import config, plugin_of
from ...hysteresis.engine.native._memory import doubles, int32_at, name2id, pointer_at
from ...hysteresis.engine.native._text import (
    SENTENCE_LIMIT,
    add,
    add_text,
    count_words,
    ends_with,
    issue,
    parse_numbers,
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
LIMB, EXO, FORCE_SENSOR, TORQUE_SENSOR, ENERGY_SENSOR = range(5)

# A fault is a reason and, where there is one, the config key it is about.
REASONS = 8
FINE, NO_SITE, SAME_BODY, NOT_STIFFNESS, NOT_OFFSET, SENSOR_NAME, SENSOR_TWICE, TOO_LARGE = range(8)


@njit(inline="always")
def number_of(wires, kind):
    """Returns the number of a site or sensor, or -1."""
    return ((wires >> (BITS * kind)) & LARGEST) - 1


@njit(cache=True)
def sensor_name(m, sensor, at):
    """Returns the address of a sensor's name."""
    return pointer_at(m + at.m_names) + int32_at(pointer_at(m + at.m_name_sensoradr), sensor)


@njit(cache=True)
def sensor_kind(name):
    """Returns what a sensor measures, as its name says, or -1."""
    if ends_with(name, b"force"):
        return FORCE_SENSOR
    if ends_with(name, b"torque"):
        return TORQUE_SENSOR
    return ENERGY_SENSOR if ends_with(name, b"energy") else -1


@njit(cache=True)
def connect(m, instance, at):
    """Returns (fault, packed numbers of the two sites and this instance's sensors)."""
    if max(pointer_at(m + at.m_nsite), pointer_at(m + at.m_nsensor)) >= LARGEST:
        return TOO_LARGE, 0
    wires = 0
    for end in (LIMB, EXO):
        site = name2id(m, at.object_site, config(m, instance, end, at))
        if site < 0:
            return NO_SITE + REASONS * end, 0
        wires |= (site + 1) << (BITS * end)
    bodies = pointer_at(m + at.m_site_bodyid)
    if int32_at(bodies, number_of(wires, LIMB)) == int32_at(bodies, number_of(wires, EXO)):
        return SAME_BODY + REASONS * EXO, 0
    for i in range(pointer_at(m + at.m_nsensor)):
        ours = int32_at(pointer_at(m + at.m_sensor_plugin), i) == instance
        if ours and int32_at(pointer_at(m + at.m_sensor_type), i) == at.sensor_plugin:
            kind = sensor_kind(sensor_name(m, i, at))
            if kind < 0:
                return SENSOR_NAME, 0
            if number_of(wires, kind) >= 0:
                return SENSOR_TWICE, 0
            wires |= (i + 1) << (BITS * kind)
    return FINE, wires


@njit(cache=True)
def configure(m, instance, address, at):
    """Fills the parameters at `address` from the config; what is not given is 0."""
    for key in range(FIRST_NUMBERS, len(KEYS)):
        first = 3 * (key - FIRST_NUMBERS)
        values = doubles(address + 8 * first, 3)
        values[:] = 0.0
        text = config(m, instance, key, at)
        count = parse_numbers(text, values)
        if count_words(text) > 0 and count != 3:
            return (NOT_OFFSET if first == OFFSET else NOT_STIFFNESS) + REASONS * key
        for i in range(3):
            if first == OFFSET and not abs(values[i]) <= LARGEST_OFFSET:
                return NOT_OFFSET + REASONS * key
            if first != OFFSET and not values[i] >= 0:
                return NOT_STIFFNESS + REASONS * key
    return FINE


@njit(cache=True)
def reason_for(sentence, n, reason):
    """Appends what is wrong and how to mend it; returns the new length."""
    if reason == NO_SITE:
        return add(
            sentence,
            n,
            b"the model has no such site; name one, and attach bushings after a spec got its name "
            b"prefix",
        )
    if reason == SAME_BODY:
        return add(sentence, n, b"it is on the same body as the limb site; name one on another")
    if reason == NOT_STIFFNESS:
        return add(sentence, n, b"give three finite numbers of at least 0")
    if reason == NOT_OFFSET:
        return add(sentence, n, b"give three finite numbers from -0.1 to 0.1 m")
    if reason == SENSOR_NAME:
        return add(
            sentence,
            n,
            b"the name of each of its sensors must end in force, torque or energy, which is what "
            b"it measures",
        )
    if reason == SENSOR_TWICE:
        return add(sentence, n, b"two of its sensors measure the same; leave one out")
    return add(sentence, n, b"the model has more than 4094 sites or sensors; make it smaller")


@njit(cache=True)
def complain(m, instance, fault, at):
    """Issues the sentence of a fault as a MuJoCo warning."""
    reason, key = fault % REASONS, fault // REASONS
    plugin = plugin_of(m, instance, at)
    sentence = np.zeros(SENTENCE_LIMIT, np.uint8)
    n = add_text(sentence, 0, pointer_at(plugin))
    n = add(sentence, n, b" of limb site '")
    n = add_text(sentence, n, config(m, instance, LIMB, at))
    n = add(sentence, n, b"': ")
    if key > LIMB:
        n = add_text(sentence, n, pointer_at(pointer_at(plugin + at.p_attributes) + 8 * key))
        n = add(sentence, n, b" is '")
        n = add_text(sentence, n, config(m, instance, key, at))
        n = add(sentence, n, b"': ")
    reason_for(sentence, n, reason)
    issue(sentence)
