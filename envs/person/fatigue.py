"""Fatigue and recovery of the wearer's muscles: the three-compartment controller 3CC-r.

Of a muscle group a part is active, a part fatigued and the rest resting (Xia and Frey-Law 2008).
Active muscle tires, and fatigued muscle recovers:

    d fatigued / dt = F · active - R · fatigued

At rest R is multiplied by r (Looft et al. 2018). In the original a controller makes the active part
follow the load within 0.1 s; here it follows at once, as far as unfatigued muscle remains:

    active = min(load, 1 - fatigued),  resting = 1 - active - fatigued

So the fatigued part is the whole state, and a step under constant load has a closed form: it is
exact for any length. Multiply `isometric_strength` by 1 - fatigued to get the remaining strength.
Antagonist torques that cancel out cause no fatigue here.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError, unknown_name
from ..provenance import numbers_of, values_of


@njit(cache=True)
def loaded(asked: float, available: float) -> float:
    """Returns the load of a muscle group: the torque asked over the available strength [N·m].

    The load is 1 where torque is asked of a group that can give none.
    """
    if asked <= 0.0:
        return 0.0
    return asked / available if available > 0.0 else 1.0


@njit(cache=True)
def tired(
    fatigued: float,
    load: float,
    tiring: float,
    recovery: float,
    multiplier: float,
    resting: float,
    dt: float,
) -> float:
    """Returns the fatigued part of a muscle group, from 0 to 1, after `dt` [s] of constant load.

    A load above what the remaining muscle can bear counts as all of that muscle. The rates are
    those of `RATES`.
    """
    if load <= resting:
        recovery = recovery * multiplier
    ceiling = 1.0 - load
    able = fatigued <= ceiling
    rate = recovery if able else tiring + recovery
    goal = (load if able else 1.0) * tiring / rate
    before = dt
    # The flow is continuous where ability ends, so a group passes the ceiling once or never.
    if (goal > ceiling) == able:
        share = (goal - ceiling) / (goal - fatigued)
        before = min(-math.log(share) / rate, dt) if share > 0.0 else dt
    fatigued = fatigued + (fatigued - goal) * math.expm1(-rate * before)
    rate = tiring + recovery if able else recovery
    goal = (1.0 if able else load) * tiring / rate
    return fatigued + (fatigued - goal) * math.expm1(-rate * (dt - before))


_REGION_OF = {
    "shoulder_abduction": "shoulder",
    "shoulder_flexion": "shoulder",
    "elbow_flexion": "elbow",
    "wrist_flexion": "grip",
}
PROVENANCE = numbers_of("fatigue")
_VALUE = values_of(PROVENANCE)
_TIRING, _RECOVERY, _MULTIPLIER = np.array(
    [
        [_VALUE[f"fatigue.{_REGION_OF[joint]}.{column}"] for joint in JOINTS]
        for column in ("fatigue_rate", "recovery_rate", "rest_multiplier")
    ]
)
_RESTING = np.full(len(JOINTS), _VALUE["fatigue.resting_load"])
RATES = np.array([_TIRING, _RECOVERY, _MULTIPLIER, _RESTING])
"""F and R [1/s], r and the load below which a group rests, shape (4, joints)."""


def endurance_time(load: ArrayLike, joint: str) -> Array:
    """Returns the time for which a rested wearer can sustain a load at a joint of `JOINTS` [s].

    `load` is a share of the unfatigued strength from 0 to 1, any shape. The time is -log(1 - R(1 -
    load) / (F load)) / R, and infinite up to the load R / (F + R).
    """
    if joint not in JOINTS:
        raise unknown_name("joint", joint, JOINTS)
    load = np.asarray(load, dtype=float)
    if not np.all((load >= 0) & (load <= 1)):
        raise InputError(f"load is {load}: give it as a fraction of strength, from 0 to 1")
    i = JOINTS.index(joint)
    tiring, recovery = _TIRING[i], _RECOVERY[i]
    with np.errstate(divide="ignore"):
        share = recovery * (1 - load) / (tiring * load)
        return -np.log1p(-np.minimum(share, 1)) / recovery
