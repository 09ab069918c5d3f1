"""The plan of one episode: intended motion of the wearer, and loads on the hand."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import AnyArray, Array
from ...assets import JOINTS
from ...errors import InputError, shown
from ..model.config import HEAVIEST_PAYLOAD
from ..model.workplace import PUSHES

ROUNDING = 1e-9  # [rad], tolerance of an intention at the end of a joint's range
STRONGEST = 1000.0  # [N], greatest push

Motion = tuple[Array, Array, Array]
"""Intended angles [rad] and their two derivatives, shape (samples, 4) each."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Intended motion of the wearer in one episode, and loads on the hand.

    Attributes:
        motion: Intended angles [rad] and two derivatives, shape (samples, 4) each.
        mass: Load in the hand at every sample [kg], shape (samples,); None for a task without
            load.
        push: Force on the grip at every sample, forward, outward and up [N], shape (samples, 3),
            zero at first; None for a task without force.
        watched: Whether the task judges the hand at each sample, shape (samples,); None for never.
    """

    motion: Motion
    mass: Array | None = None
    push: Array | None = None
    watched: AnyArray | None = None


def checked_plan(plan: Plan, samples: int, ranges: Array, *, carries: bool, pushes: bool) -> Plan:
    """Returns a plan of arrays; raises an InputError if a number is not finite or out of range."""
    if not isinstance(plan, Plan):
        raise InputError(f"the task's plan is {shown(plan)}: return a Plan")
    motion = valid_motion(plan.motion, samples, ranges)
    mass = series("the task's mass", plan.mass, (samples,))
    push = series("the task's push", plan.push, (samples, len(PUSHES)))
    watched = series("the task's watched", plan.watched, (samples,))
    if mass is not None:
        if not carries:
            raise InputError("the task's plan has a mass: set carries = True in its class")
        if mass.min() < 0 or mass.max() > HEAVIEST_PAYLOAD:
            raise InputError(
                f"the task's load is {mass.min():g} to {mass.max():g} kg: stay between 0 and "
                f"{HEAVIEST_PAYLOAD:g} kg"
            )
    if push is not None:
        if not pushes:
            raise InputError("the task's plan has a push: call add_pushes(spec) in its edit")
        if push[0].any():
            raise InputError(f"the task's push begins with {push[0].tolist()} N: begin with 0")
        if np.abs(push).max() > STRONGEST:
            raise InputError(
                f"the task's push reaches {np.abs(push).max():g} N: stay within {STRONGEST:g} N"
            )
    return Plan(motion, mass, push, None if watched is None else watched != 0)


def series(name: str, given: Any, shape: tuple[int, ...]) -> Array | None:
    """Returns finite numbers of the given shape, or None if none are given."""
    if given is None:
        return None
    values = _numbers(name, given)
    if values.shape != shape:
        raise InputError(f"{name} has shape {values.shape}: give finite numbers of shape {shape}")
    if not np.isfinite(values).all():
        sample = int(np.argwhere(~np.isfinite(values))[0, 0])
        raise InputError(f"{name} is not finite at sample {sample}: give finite numbers")
    return values


def _numbers(name: str, given: Any) -> Array:
    try:
        return np.asarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} is {shown(given)}: give numbers") from error


def valid_motion(motion: Motion, samples: int, ranges: Array) -> Motion:
    """Checks that an arm with some ranges of joints [rad], shape (4, 2), can carry out a motion."""
    if not isinstance(motion, list | tuple) or len(motion) != 3:
        raise InputError(
            f"the task's motion is {shown(motion)}: return angle, rate and acceleration"
        )
    angle, rate, acceleration = (_numbers("the task's motion", part) for part in motion)
    shape, shapes = (samples, len(JOINTS)), [part.shape for part in (angle, rate, acceleration)]
    if shapes != [shape] * 3 or not np.isfinite(angle + rate + acceleration).all():
        raise InputError(
            f"the task's motion has arrays of shape {', '.join(map(str, shapes))}: give angle, "
            f"rate and acceleration, finite numbers of shape {shape} each"
        )
    outside = (angle.min(axis=0) < ranges[:, 0] - ROUNDING) | (
        angle.max(axis=0) > ranges[:, 1] + ROUNDING
    )
    if outside.any():
        column = int(outside.argmax())
        least, most = angle[:, column].min(), angle[:, column].max()
        low, high = ranges[column]
        raise InputError(
            f"the task's motion takes {JOINTS[column]} from {least:.3g} to {most:.3g} rad: stay "
            f"between {low:.3g} and {high:.3g} rad"
        )
    return angle, rate, acceleration
