"""The faults that an instance of any model can have, and the sentences that report them.

A fault is a reason and the config key that it is about, `JOINT` where it is about the instance as a
whole. Reasons from `MODEL` on are the model's own complaints (`COMPLAINTS` of its kernels).
"""

# pyright: reportGeneralTypeIssues=false

import numpy as np

from ...kernels import inner
from .native import add, add_choices, begin_complaint, issue

# Config keys of every model; the model's own follow.
COMMON_KEYS = (
    "joint",
    "start_angle",
    "start_torque",
    "start_path",
    "polynomial",
    "angle_range",
    "viscoelastic",
    "gap",
    "allow_uncertified",
    "taken_off",
)
(
    JOINT,
    START_ANGLE,
    START_TORQUE,
    START_PATH,
    POLYNOMIAL,
    ANGLE_RANGE,
    VISCOELASTIC,
    GAP,
    ALLOW,
    TAKEN_OFF,
    FIRST_KEY,
) = np.arange(11)  # no Python numbers, for which numba compiles functions anew

(
    FINE,
    NO_JOINT,
    JOINT_TYPE,
    JOINT_TWICE,
    NUMBER,
    NUMBERS,
    WORD,
    TOO_MANY,
    RANGE,
    THREE,
    ABOVE_0,
    FLAG,
    UNCERTIFIED,
    FAR_START,
    NO_START,
    NO_PATH,
    SENSOR_NAME,
    SENSOR_TWICE,
    TOO_LARGE,
    POLE,
) = np.arange(20)
SENTENCES = (  # order of the names above
    b"",
    b"the model has no such joint; name a hinge or a slide, and attach hysteresis "
    b"after a spec got its name prefix",
    b"it is not a hinge or a slide joint; name one",
    b"another instance resists it already; give each joint one, and take the others off",
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
    b"it starts too far from rest for the certificate; change start_angle or start_torque",
    b"it cannot have start_torque at start_angle; start nearer to 0",
    b"its torque becomes infinite on the way; stay nearer to the start",
    b"the name of each of its sensors must end in torque, stiffness or energy, "
    b"which is what it measures",
    b"two of its sensors measure the same; leave one out",
    b"the model has more than 16383 joints or sensors; make it smaller",
    b"its torque met a pole (or the parameters in its state are out of range); the torque stays "
    b"at its last valid value, and the fault flag is set",
)
MODEL = len(SENTENCES)


@inner(cache=False)
def complain_of(kernels, words, m, instance, fault, at):
    """Issues the sentence of a fault as a MuJoCo warning."""
    reason, key = fault
    sentence, n = begin_complaint(m, instance, b"joint", JOINT, key, at)
    if reason >= MODEL:
        n = add(sentence, n, kernels.COMPLAINTS[reason - MODEL])
    else:
        n = add(sentence, n, SENTENCES[reason])
    if reason == WORD:
        n = add_choices(sentence, n, words[key - FIRST_KEY])
    issue(sentence)
