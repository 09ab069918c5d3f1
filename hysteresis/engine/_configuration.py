"""Sets an instance up from its MJCF config: its joint, sensors, parameters and memory.

`kernels` is the module of the model's kernels; `kinds` and `words` have the kind and the allowed
words of each of the model's own config keys. A fault is a reason and the wrong config key, which is
`JOINT` for a fault of the whole instance. Reasons from `MODEL` on are the model's own complaints
(`COMPLAINTS` of its kernels).

`mjData.plugin_state` holds the physical state of an instance: fault flag, memory, parameters
(radians), the elastic polynomial, the range, the viscoelastic part and the play. These numbers are
saved, copied and batched with the rest of the state, and may differ between simulations.
`mjData.plugin_data` holds the ids of the joint and of the sensors, packed into one integer. A state
may be set on any MuJoCo model: ids and sizes come from the model at hand.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from collections import namedtuple

import numpy as np
from numba import njit

from ...kernels import inner
from ..around import backlash_kernels as backlash
from ..around import viscoelastic_kernels as viscoelastic
from ..polynomial import value_of
from . import native

FAULT, MEMORY = 0, 1
OFF = 2.0  # flag of an instance that is taken off and gives no torque
POLYNOMIAL_LIMIT = 6  # number of coefficients, of angle^0 to angle^5

# A pointer-sized word holds four ids of 14 bits, the length of the polynomial (3 bits), whether the
# torque is constant outside a range, whether there is a viscoelastic part and whether there is play
# (1 bit each). Sensors count from 1; 0 is none.
BITS, LARGEST = 14, 2**14 - 1
WIDTH = np.int64(BITS)
SENSORS = b"torque stiffness energy"  # endings of the names of sensors, from `TORQUE_SENSOR` on
TORQUE_SENSOR, STIFFNESS_SENSOR, ENERGY_SENSOR = map(np.int64, (1, 2, 3))
POLYNOMIAL_SHIFT, HELD_SHIFT, VISCOELASTIC_SHIFT = 4 * BITS, 4 * BITS + 3, 4 * BITS + 4
PLAY_SHIFT = 4 * BITS + 5


Layout = namedtuple(
    "Layout",
    "m_opt__timestep m_nsensor m_njnt m_jnt_type m_jnt_qposadr m_jnt_dofadr m_qpos0 m_sensor_type "
    "m_sensor_plugin m_sensor_adr m_plugin m_plugin_stateadr m_plugin_statenum m_plugin_attr "
    "m_plugin_attradr m_names m_name_sensoradr d_qpos d_qvel d_qfrc_passive d_sensordata "
    "d_plugin_state d_plugin_data mjOBJ_JOINT mjJNT_SLIDE mjJNT_HINGE mjSENS_PLUGIN "
    "mjPLUGIN_PASSIVE stamp",
    defaults=(0,),
)
"""Byte offsets of fields in mjModel (m_) and mjData (d_), and values of some enums.

`stamp` distinguishes versions of a model's kernels and of the engine, so that numba's cache does
not give back machine code of an older version.
"""


@njit(inline="always")
def parts(kernels, ids, address, size):
    """Returns views of a state's flag, memory, parameters, polynomial, range, rate and play."""
    polynomial, limits = (ids >> POLYNOMIAL_SHIFT) & 7, 2 * ((ids >> HELD_SHIFT) & 1)
    rate = viscoelastic.SIZE * ((ids >> VISCOELASTIC_SHIFT) & 1)
    play = backlash.SIZE * (ids >> PLAY_SHIFT)
    own = size - MEMORY - polynomial - limits - rate - play
    memory = kernels.memory_size(own)
    start = address + 8 * MEMORY
    end = start + 8 * own
    return (
        native.doubles(address, 1),
        native.doubles(start, memory),
        native.doubles(start + 8 * memory, own - memory),
        native.doubles(end, polynomial),
        native.doubles(end + 8 * polynomial, limits),
        native.doubles(end + 8 * (polynomial + limits), rate),
        native.doubles(end + 8 * (polynomial + limits + rate), play),
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
    return native.packed(ids, kind, WIDTH)


# Config keys of every model; the model's own keys follow. The numbers are of NumPy, since numba
# would compile functions anew for each number of Python.
COMMON_KEYS = tuple(
    "joint start_angle start_torque start_path polynomial angle_range viscoelastic gap "
    "allow_uncertified taken_off".split()
)
JOINT, START_ANGLE, START_TORQUE, START_PATH, POLYNOMIAL, ANGLE_RANGE = np.arange(6)
VISCOELASTIC, GAP, ALLOW, TAKEN_OFF, FIRST_KEY = np.arange(6, 11)

FINE, NO_JOINT, JOINT_TYPE, JOINT_TWICE, NUMBER, NUMBERS, WORD, TOO_MANY, RANGE = np.arange(9)
THREE, ABOVE_0, FLAG, UNCERTIFIED, FAR_START, NO_START, NO_PATH = np.arange(9, 16)
SENSOR_NAME, SENSOR_TWICE, TOO_LARGE, POLE = np.arange(16, 20)
SENTENCES = (  # order of the names above
    b"",
    b"the model has no such joint; name a hinge or a slide, and attach hysteresis "
    b"after a spec got its name prefix",
    b"the joint is not a hinge or a slide joint; name a hinge or a slide",
    b"another instance resists the joint already; give each joint one, and take the others off",
    b"give one number, 0 or 1e-100 to 1e100 in size",
    b"give numbers, 0 or 1e-100 to 1e100 in size, with blanks between them",
    b"use ",
    b"give at most 6 coefficients (of angle to the 0 to 5)",
    b"give lowest and highest angle, two ascending numbers",
    b"give damping, relaxation stiffness and relaxation time, three numbers of at least 0, the "
    b"time above 0 where there is a stiffness",
    b"give one number above 0, the angle by which the joint moves freely",
    b"use true or false",
    b"its parameters have no certificate (a motion could meet infinite torque, or "
    b"gain energy); set allow_uncertified to true to run anyway",
    b"the model starts too far from rest for the certificate; change start_angle or start_torque",
    b"the model cannot have start_torque at start_angle; start nearer to 0",
    b"its torque becomes infinite on the way; stay nearer to the start",
    b"the name of each of its sensors must end in torque, stiffness or energy, "
    b"which is the measured quantity",
    b"two of its sensors measure the same; leave one out",
    b"the model has more than 16383 joints or sensors; make the model smaller",
    b"its torque met a pole (or the parameters in its state are out of range); the torque stays "
    b"at its last valid value, and the fault flag is set",
)
MODEL = len(SENTENCES)

# Kinds of config keys. The number of an optional kind is `OPTIONAL` more.
A_NUMBER, A_LIST, A_WORD, OPTIONAL = 0, 1, 2, 3


@inner(cache=False)
def complain_of(kernels, words, m, instance, fault, at):
    """Issues the sentence of a fault as a MuJoCo warning."""
    reason, key = fault
    sentence, n = native.begin_complaint(m, instance, b"joint", JOINT, key, at)
    if reason >= MODEL:
        n = native.add(sentence, n, kernels.COMPLAINTS[reason - MODEL])
    else:
        n = native.add(sentence, n, SENTENCES[reason])
    if reason == WORD:
        n = native.add_choices(sentence, n, words[key - FIRST_KEY])
    native.issue(sentence)


@inner
def is_hysteretic(m, instance, at):
    """Returns whether an instance has a hysteresis plugin, by the first two config keys."""
    if not native.starts_with(native.plugin_name(m, instance, at), b"activesuit."):
        return False
    if native.choice_of(native.key_name(m, instance, JOINT, at), b"joint") != 0:
        return False
    return native.choice_of(native.key_name(m, instance, START_ANGLE, at), b"start_angle") == 0


@inner
def polynomial_size(m, instance, at):
    """Returns how many coefficients an instance's elastic polynomial has."""
    return min(native.count_words(native.config(m, instance, POLYNOMIAL, at)), POLYNOMIAL_LIMIT)


@inner
def is_given(m, instance, key, at):
    """Returns 1 if an instance gives a value of a key, else 0."""
    return 1 if native.count_words(native.config(m, instance, key, at)) > 0 else 0


@inner
def connect(m, instance, at):
    """Returns (fault, packed ids of the joint and of this instance's sensors)."""
    if max(native.pointer_at(m + at.m_njnt), native.pointer_at(m + at.m_nsensor)) >= LARGEST:
        return (TOO_LARGE, JOINT), 0
    joint = native.name2id(m, at.mjOBJ_JOINT, native.config(m, instance, JOINT, at))
    if joint < 0:
        return (NO_JOINT, JOINT), 0
    joint_type = native.int32_at(native.pointer_at(m + at.m_jnt_type), joint)
    if joint_type not in (at.mjJNT_SLIDE, at.mjJNT_HINGE):
        return (JOINT_TYPE, JOINT), 0
    for other in range(instance):
        same = native.name2id(m, at.mjOBJ_JOINT, native.config(m, other, JOINT, at)) == joint
        both = same and is_hysteretic(m, other, at)
        if both and not (flag_of(m, instance, TAKEN_OFF, at) or flag_of(m, other, TAKEN_OFF, at)):
            return (JOINT_TWICE, JOINT), 0
    ids = joint | polynomial_size(m, instance, at) << POLYNOMIAL_SHIFT
    ids |= is_given(m, instance, ANGLE_RANGE, at) << HELD_SHIFT
    ids |= is_given(m, instance, VISCOELASTIC, at) << VISCOELASTIC_SHIFT
    ids |= is_given(m, instance, GAP, at) << PLAY_SHIFT
    outcome, ids = native.pack_sensors(m, instance, ids, TORQUE_SENSOR, WIDTH, SENSORS, at)
    if outcome != native.FOUND:
        return (SENSOR_NAME if outcome == native.UNKNOWN else SENSOR_TWICE, JOINT), 0
    return (FINE, JOINT), ids


@inner
def count_values(m, instance, kinds, counts, at):
    """Fills `counts` with how many values each of the model's own keys has."""
    for i in range(len(kinds)):
        counts[i] = 1
        if kinds[i] % OPTIONAL == A_LIST:
            counts[i] = native.count_words(native.config(m, instance, FIRST_KEY + i, at))


@njit(inline="always")
def required_size(kernels, kinds, m, instance, at):
    """Returns how many numbers of plugin_state an instance needs."""
    counts = np.empty(len(kinds), np.int64)
    count_values(m, instance, kinds, counts, at)
    more = polynomial_size(m, instance, at) + 2 * is_given(m, instance, ANGLE_RANGE, at)
    rate = viscoelastic.SIZE * is_given(m, instance, VISCOELASTIC, at)
    play = backlash.SIZE * is_given(m, instance, GAP, at)
    return MEMORY + kernels.size(counts) + more + rate + play


@inner
def read_values(m, instance, kinds, words, counts, values, at):
    """Fills `values` with the values of all keys, one key after the other; returns a fault."""
    start = 0
    for i in range(len(kinds)):
        text = native.config(m, instance, FIRST_KEY + i, at)
        part, kind = values[start : start + counts[i]], kinds[i] % OPTIONAL
        start += counts[i]
        part[:] = 0.0
        if kinds[i] >= OPTIONAL and native.count_words(text) == 0:
            continue
        if kind == A_WORD:
            part[0] = native.choice_of(text, words[i])
            if part[0] < 0:
                return WORD, FIRST_KEY + i
        elif native.parse_numbers(text, part) != (1 if kind == A_NUMBER else max(part.size, 1)):
            return NUMBER if kind == A_NUMBER else NUMBERS, FIRST_KEY + i
    return FINE, JOINT


@inner
def configure(kernels, kinds, words, m, instance, ids, address, size, at):
    """Fills the state from the config; returns a fault.

    Calls are rare, so the function is compiled once for a model, and not inlined in two callbacks.
    """
    flag, memory, p, polynomial, limits, rate, play = parts(kernels, ids, address, size)
    flag[0] = 1.0
    counts = np.empty(len(kinds), np.int64)
    count_values(m, instance, kinds, counts, at)
    values = np.empty(counts.sum())
    fault = read_values(m, instance, kinds, words, counts, values, at)
    if fault[0] == FINE:
        ends = np.cumsum(counts)
        complaint, key = kernels.complaint(values, ends)
        if complaint != FINE:
            fault = (MODEL + complaint, FIRST_KEY + key)
        else:
            kernels.configure(values, ends, p)
    if fault[0] == FINE:
        fault = read_around(m, instance, polynomial, limits, rate, play, at)
    if fault[0] == FINE:
        fault = start(kernels, m, instance, joint_of(ids), memory, p, polynomial, limits, play, at)
    if fault[0] == FINE and flag_of(m, instance, TAKEN_OFF, at) < 0:
        fault = (FLAG, TAKEN_OFF)
    flag[0] = fault[0] != FINE
    if fault[0] == FINE and flag_of(m, instance, TAKEN_OFF, at) == 1:
        flag[0] = OFF
    return fault


@inner
def read_around(m, instance, polynomial, limits, rate, play, at):
    """Reads polynomial, range, viscoelastic part and play, where given; returns a fault."""
    count = native.parse_numbers(native.config(m, instance, POLYNOMIAL, at), polynomial)
    if not 0 <= count <= POLYNOMIAL_LIMIT:
        return NUMBERS if count < 0 else TOO_MANY, POLYNOMIAL
    if limits.size > 0:
        count = native.parse_numbers(native.config(m, instance, ANGLE_RANGE, at), limits)
        if not (count == 2 and limits[0] < limits[1]):
            return RANGE, ANGLE_RANGE
    if rate.size > 0:
        rate[:] = 0.0
        given = rate[: viscoelastic.NUMBERS]
        count = native.parse_numbers(native.config(m, instance, VISCOELASTIC, at), given)
        if not (count == viscoelastic.NUMBERS and viscoelastic.is_sound(rate)):
            return THREE, VISCOELASTIC
    if play.size > 0:
        play[:] = 0.0
        count = native.parse_numbers(native.config(m, instance, GAP, at), play[: backlash.END])
        if not (count == 1 and backlash.is_sound(play)):
            return ABOVE_0, GAP
    return FINE, JOINT


@inner
def read_start(m, instance, joint, at):
    """Reads the start; returns (fault, angle, torque), by default qpos0 of the joint and 0."""
    qpos = native.int32_at(native.pointer_at(m + at.m_jnt_qposadr), joint)
    found = np.zeros(2)
    found[0] = native.doubles(native.pointer_at(m + at.m_qpos0), qpos + 1)[qpos]
    for i in range(2):
        text = native.config(m, instance, START_ANGLE + i, at)
        if native.count_words(text) > 0 and native.parse_numbers(text, found[i : i + 1]) != 1:
            return (NUMBER, START_ANGLE + i), 0.0, 0.0
    return (FINE, JOINT), found[0], found[1]


@inner
def flag_of(m, instance, key, at):
    """Reads a key that may be true or false: 1, 0, or -1 for another word."""
    text = native.config(m, instance, key, at)
    return 0 if native.length(text) == 0 else native.choice_of(text, b"false true")


@njit(inline="always")
def start(kernels, m, instance, joint, memory, p, polynomial, limits, play, at):
    """Begins the memory at the start, and moves the memory along `start_path`; returns a fault.

    A model without a certificate, or a start outside the certificate, is a fault too, unless the
    config allows both.
    """
    fault, angle, torque = read_start(m, instance, joint, at)
    allowed = flag_of(m, instance, ALLOW, at)
    if fault[0] != FINE:
        return fault
    if allowed < 0:
        return FLAG, ALLOW
    if play.size > 0:
        angle = backlash.begun(play[backlash.GAP], angle, torque)
        play[backlash.END] = angle
    torque -= value_of(polynomial, angle)
    low, high = -math.inf, math.inf
    if limits.size > 0:
        low, high = limits[0], limits[1]
        angle = min(max(angle, low), high)
    inside = kernels.begin(p, memory, angle, torque)
    certified, inside = kernels.certify(p, memory, inside, low, high)
    if not (allowed == 1 or certified):
        return UNCERTIFIED, JOINT
    if math.isnan(inside):
        return NO_START, JOINT
    if not (allowed == 1 or inside >= 0):
        return FAR_START, JOINT
    path = np.empty(native.count_words(native.config(m, instance, START_PATH, at)))
    if native.parse_numbers(native.config(m, instance, START_PATH, at), path) != path.size:
        return NUMBERS, START_PATH
    for end in path:
        turn = min(max(end, low), high)
        if play.size > 0:
            side = backlash.end_at(kernels, p, memory, polynomial, limits, play, end)
            play[backlash.END], turn = side, min(max(side, low), high)
        if turn != memory[0] and math.isnan(kernels.commit(p, memory, turn)):
            return NO_PATH, START_PATH
    return FINE, JOINT
