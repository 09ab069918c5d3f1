"""Access to an instance of a plugin: its config, state and sensors, and complaints about it.

Every function takes the addresses of mjModel (`m`) or mjData (`d`), the number of the instance, and
`at`, the `layout` of the plugin with the fields that the function names.

Several numbers of `bits` bits each stand in the pointer-sized word that an instance keeps. They
count from 1, and 0 is none.

Most of the functions are not cached by themselves: such a cache would contain the layout classes of
all plugins, and would be unreadable without the module of one of them. They are compiled into the
plugin's own code.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import numpy as np
from numba import njit

from ....kernels import inner
from ._layout import ATTRIBUTES
from ._memory import character_at, doubles, int32_at, plugin_at, pointer_at, store_pointer
from ._text import SENTENCE_LIMIT, add, add_text, is_word, issue, length

FOUND, UNKNOWN, TWICE = range(3)


@inner(cache=False)
def config(m, instance, key, at):
    """Returns the address of the value of config key number `key`, a C string ("" if not given).

    It reads m_plugin_attr and m_plugin_attradr.
    """
    text = pointer_at(m + at.m_plugin_attr) + int32_at(
        pointer_at(m + at.m_plugin_attradr), instance
    )
    for _ in range(key):
        while character_at(text) != 0:
            text += 1
        text += 1
    return text


@inner(cache=False)
def plugin_name(m, instance, at):
    """Returns the address of the name of an instance's plugin; it reads m_plugin."""
    return pointer_at(plugin_at(int32_at(pointer_at(m + at.m_plugin), instance)))


@inner(cache=False)
def key_name(m, instance, key, at):
    """Returns the address of the name of a config key; it reads m_plugin."""
    plugin = plugin_at(int32_at(pointer_at(m + at.m_plugin), instance))
    return pointer_at(pointer_at(plugin + ATTRIBUTES) + 8 * key)


@njit(inline="always")
def state_of(m, d, instance, at):
    """Returns the address of an instance's numbers in `mjData.plugin_state`.

    It reads m_plugin_stateadr and d_plugin_state.
    """
    address = int32_at(pointer_at(m + at.m_plugin_stateadr), instance)
    return pointer_at(d + at.d_plugin_state) + 8 * address


@njit(inline="always")
def state_size(m, instance, at):
    """Returns how many numbers of `plugin_state` an instance has; it reads m_plugin_statenum."""
    return int32_at(pointer_at(m + at.m_plugin_statenum), instance)


@inner(cache=False)
def word_of(d, instance, at):
    """Returns the integer that an instance keeps in `plugin_data`; it reads d_plugin_data."""
    return pointer_at(pointer_at(d + at.d_plugin_data) + 8 * instance)


@inner(cache=False)
def set_word(d, instance, word, at):
    """Stores the integer of `word_of`, which no reset and no saved state changes."""
    store_pointer(pointer_at(d + at.d_plugin_data) + 8 * instance, word)


@inner(cache=False)
def is_sensor_of(m, sensor, instance, at):
    """Returns whether a sensor belongs to an instance.

    It reads m_sensor_plugin, m_sensor_type and mjSENS_PLUGIN.
    """
    ours = int32_at(pointer_at(m + at.m_sensor_plugin), sensor) == instance
    return ours and int32_at(pointer_at(m + at.m_sensor_type), sensor) == at.mjSENS_PLUGIN


@inner(cache=False)
def sensor_name(m, sensor, at):
    """Returns the address of a sensor's name; it reads m_names and m_name_sensoradr."""
    return pointer_at(m + at.m_names) + int32_at(pointer_at(m + at.m_name_sensoradr), sensor)


@njit(inline="always")
def sensor_values(m, d, sensor, count, at):
    """Returns a view of the `count` values of a sensor; it reads m_sensor_adr and d_sensordata."""
    address = int32_at(pointer_at(m + at.m_sensor_adr), sensor)
    return doubles(pointer_at(d + at.d_sensordata) + 8 * address, count)


@inner(cache=False)
def begin_complaint(m, instance, noun, subject, key, at):
    """Begins a sentence about a config: "PLUGIN of NOUN 'SUBJECT': KEY is 'VALUE': ".

    Args:
        m: Address of mjModel.
        instance: Number of the instance.
        noun: Word for the thing that the instance acts on, as b"joint".
        subject: Number of the config key that names this thing.
        key: Number of the config key that is wrong; with `subject`, its part of the sentence is
            left out.
        at: Layout of the plugin.

    Returns:
        The sentence so far, to which `add` and `add_text` append, and its length.
    """
    sentence = np.zeros(SENTENCE_LIMIT, np.uint8)
    n = add_text(sentence, 0, plugin_name(m, instance, at))
    n = add(sentence, n, b" of ")
    n = add(sentence, n, noun)
    n = add(sentence, n, b" '")
    n = add_text(sentence, n, config(m, instance, subject, at))
    n = add(sentence, n, b"': ")
    if key != subject:
        n = add_text(sentence, n, key_name(m, instance, key, at))
        n = add(sentence, n, b" is '")
        n = add_text(sentence, n, config(m, instance, key, at))
        n = add(sentence, n, b"': ")
    return sentence, n


@inner(cache=False)
def complain(m, instance, noun, subject, key, reason, at):
    """Issues a MuJoCo warning: a sentence about a config that ends with `reason`."""
    sentence, n = begin_complaint(m, instance, noun, subject, key, at)
    add(sentence, n, reason)
    issue(sentence)


@inner
def packed(ids, place, bits):
    """Returns the number at a place of a word, from 0; -1 for none."""
    return ((ids >> (bits * place)) & (2**bits - 1)) - 1


@inner
def sensor_kind(name, endings):
    """Returns which of some words the C string at `name` ends with, from 0; -1 for none.

    Args:
        name: Address of the name of a sensor.
        endings: Bytes with a blank between every two words, as b"force torque".
    """
    kind, start = 0, 0
    for end in range(len(endings) + 1):
        if end == len(endings) or endings[end] == ord(" "):
            rest = length(name) - (end - start)
            if rest >= 0 and is_word(name + rest, endings, start, end):
                return kind
            kind, start = kind + 1, end + 1
    return -1


@inner
def pack_sensors(m, instance, ids, first, bits, endings, at):
    """Returns (FOUND, UNKNOWN or TWICE, the word with the sensors of an instance).

    A sensor is unknown by its name, or there twice. It reads m_nsensor and what `sensor_name` and
    `is_sensor_of` read.

    Args:
        m: Address of mjModel.
        instance: Number of the instance.
        ids: Word so far.
        first: Place of the sensor with the first ending.
        bits: Bits of each number.
        endings: Endings of the names of sensors; see `sensor_kind`.
        at: Layout of MuJoCo's structs.
    """
    for sensor in range(pointer_at(m + at.m_nsensor)):
        if is_sensor_of(m, sensor, instance, at):
            kind = sensor_kind(sensor_name(m, sensor, at), endings)
            if kind < 0:
                return UNKNOWN, ids
            if packed(ids, first + kind, bits) >= 0:
                return TWICE, ids
            ids |= (sensor + 1) << (bits * (first + kind))
    return FOUND, ids
