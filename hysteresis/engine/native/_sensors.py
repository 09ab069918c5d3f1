"""Sensors of an instance: what each measures by its name, packed into the word of the instance.

Several numbers of `bits` bits each stand in the pointer-sized word that an instance keeps. They
count from 1, and 0 is none.
"""

# pyright: reportCallIssue=false

from ....kernels import inner
from ._instance import is_sensor_of, sensor_name
from ._memory import pointer_at
from ._text import is_word, length

FOUND, UNKNOWN, TWICE = range(3)


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
