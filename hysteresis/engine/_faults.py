"""What can be wrong with an instance's config, and the sentence that says so.

A fault is a reason and, where there is one, the config key it is about: `reason + REASONS * key`.
"""

import numpy as np
from numba import njit

from ._models import JOINT
from .native._memory import character_at, int32_at, plugin_at, pointer_at
from .native._text import SENTENCE_LIMIT, add, add_text, issue

REASONS = 32
(
    FINE,
    NO_JOINT,
    JOINT_TYPE,
    NUMBER,
    POSITIVE,
    AT_LEAST_0,
    FROM_1_TO_1E6,
    NOT_ZERO,
    NUMBERS,
    ASCENDING,
    AS_MANY,
    DENSITY_SIZE,
    TOO_MANY,
    UNIT,
    FORM,
    CLAMP,
    FLAG,
    UNCERTIFIED,
    FAR_START,
    NO_START,
    SENSOR_NAME,
    SENSOR_TWICE,
    TOO_LARGE,
    POLE,
    RANGE,
    JOINT_TWICE,
) = range(26)


@njit(cache=True)
def config(m, instance, key, at):
    """Returns the address of the value of config key number `key`, a C string ("" if not given)."""
    text = pointer_at(m + at.m_plugin_attr) + int32_at(
        pointer_at(m + at.m_plugin_attradr), instance
    )
    for _ in range(key):
        while character_at(text) != 0:
            text += 1
        text += 1
    return text


@njit(cache=True)
def plugin_of(m, instance, at):
    """Returns the address of the C struct of an instance's plugin: its name comes first."""
    return plugin_at(int32_at(pointer_at(m + at.m_plugin), instance))


@njit(cache=True)
def reason_for(sentence, n, reason):  # noqa: PLR0912 (one branch a sentence)
    """Appends what is wrong and how to mend it; returns the new length."""
    if reason == NO_JOINT:
        return add(
            sentence,
            n,
            b"the model has no such joint; name a hinge or a slide, and attach hysteresis after a "
            b"spec got its name prefix",
        )
    if reason == JOINT_TWICE:
        return add(sentence, n, b"another instance resists it already; give each joint one")
    if reason == JOINT_TYPE:
        return add(sentence, n, b"it is not a hinge or a slide joint; name one")
    if reason == NUMBER:
        return add(sentence, n, b"give one finite number")
    if reason == POSITIVE:
        return add(sentence, n, b"give a number above 0")
    if reason == AT_LEAST_0:
        return add(sentence, n, b"give a number of at least 0 (below 1 for form jiles-1992)")
    if reason == FROM_1_TO_1E6:
        return add(sentence, n, b"give a number from 1 to 1e6")
    if reason == NOT_ZERO:
        return add(sentence, n, b"give a number other than 0")
    if reason == NUMBERS:
        return add(sentence, n, b"give finite numbers with blanks between them")
    if reason == ASCENDING:
        return add(sentence, n, b"give increasing numbers (thresholds above 0, levels two or more)")
    if reason == AS_MANY:
        return add(sentence, n, b"give as many numbers as thresholds or segments between levels")
    if reason == DENSITY_SIZE:
        return add(sentence, n, b"n segments between levels need n (n + 1) / 2 numbers, row by row")
    if reason == TOO_MANY:
        return add(sentence, n, b"give at most 6 coefficients (of angle to the 0 to 5)")
    if reason == UNIT:
        return add(sentence, n, b"use rad or deg")
    if reason == FORM:
        return add(sentence, n, b"use bulk, original, derivative or jiles-1992")
    if reason == CLAMP:
        return add(sentence, n, b"use none, jiles or irreversible")
    if reason == RANGE:
        return add(sentence, n, b"give lowest and highest angle, two ascending numbers")
    if reason == FLAG:
        return add(sentence, n, b"use true or false")
    return reason_without_key(sentence, n, reason)


@njit(cache=True)
def reason_without_key(sentence, n, reason):
    """Appends the reasons that are about the whole instance."""
    if reason == UNCERTIFIED:
        return add(
            sentence,
            n,
            b"its parameters have no certificate (a motion could meet infinite torque, or gain "
            b"energy); set allow_uncertified to true to run anyway",
        )
    if reason == FAR_START:
        return add(
            sentence,
            n,
            b"it starts too far from rest for the certificate; change start_angle or start_torque",
        )
    if reason == NO_START:
        return add(sentence, n, b"it cannot hold start_torque at start_angle; start nearer to 0")
    if reason == SENSOR_NAME:
        return add(
            sentence,
            n,
            b"the name of each of its sensors must end in torque, stiffness or energy, which is "
            b"what it measures",
        )
    if reason == SENSOR_TWICE:
        return add(sentence, n, b"two of its sensors measure the same; leave one out")
    if reason == TOO_LARGE:
        return add(sentence, n, b"the model has more than 16383 joints or sensors; make it smaller")
    return add(
        sentence,
        n,
        b"its torque met a pole (or the parameters in its state are out of range); it is held at "
        b"its last valid value, and the fault flag is set",
    )


@njit(cache=True)
def complain(m, instance, fault, at):
    """Issues the sentence of a fault as a MuJoCo warning."""
    reason, key = fault % REASONS, fault // REASONS
    plugin = plugin_of(m, instance, at)
    sentence = np.zeros(SENTENCE_LIMIT, np.uint8)
    n = add_text(sentence, 0, pointer_at(plugin))
    n = add(sentence, n, b" of joint '")
    n = add_text(sentence, n, config(m, instance, JOINT, at))
    n = add(sentence, n, b"': ")
    if key != JOINT:
        n = add_text(sentence, n, pointer_at(pointer_at(plugin + at.p_attributes) + 8 * key))
        n = add(sentence, n, b" is '")
        n = add_text(sentence, n, config(m, instance, key, at))
        n = add(sentence, n, b"': ")
    reason_for(sentence, n, reason)
    issue(sentence)
