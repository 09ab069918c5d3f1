"""Kernels of fatigue."""

import math

from numba import njit


@njit(cache=True)
def loaded(asked: float, available: float) -> float:
    """Returns the load of a muscle group; 1 where it needs torque and can give none."""
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
    """Returns the fatigued part of a muscle group after `dt` under constant load."""
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
