"""Intended motions: minimum-jerk moves between random targets."""

import math
from collections.abc import Mapping

import numpy as np
from numba import njit

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError, shown

ROUNDING = 1e-9  # rad, which an intention may be beyond the range of a joint

Motion = tuple[Array, Array, Array]
"""Intended angles [rad] and their two derivatives, shape (samples, 4) each."""


def minimum_jerk(fraction: Array) -> tuple[Array, Array, Array]:
    """Returns 10 s^3 - 15 s^4 + 6 s^5 and its first two derivatives for s in [0, 1]."""
    s = fraction
    position = s**3 * (10 + s * (-15 + 6 * s))
    rate = 30 * s**2 * (1 + s * (-2 + s))
    acceleration = 60 * s * (1 + s * (-3 + 2 * s))
    return position, rate, acceleration


@njit(cache=True)
def random_moves(
    rng: np.random.Generator,
    low: float,
    high: float,
    samples: int,
    dt: float,
    move_time: tuple[float, float],
    dwell_time: tuple[float, float],
) -> Array:
    """Returns angle, rate and acceleration of minimum-jerk moves between random targets.

    Every move covers at least a quarter of the span, so that the suit resists noticeably.

    Args:
        rng: Random generator.
        low: Lowest target [rad].
        high: Highest target [rad].
        samples: Number of samples.
        dt: Time between samples [s].
        move_time: Shortest and longest time of a move [s].
        dwell_time: Shortest and longest rest after it [s].

    Returns:
        The motion, shape (3, samples).
    """
    motion = np.zeros((3, samples))
    least = (high - low) / 4.0
    here, now = rng.uniform(low, high), 0
    while now < samples:
        target = rng.uniform(low, high)
        while abs(target - here) < least:
            target = rng.uniform(low, high)
        steps = max(1, round(rng.uniform(move_time[0], move_time[1]) / dt))
        duration = steps * dt
        for i in range(now, min(now + steps, samples)):
            s = (i - now) / steps
            motion[0, i] = here + (target - here) * s**3 * (10.0 + s * (-15.0 + 6.0 * s))
            motion[1, i] = (target - here) * 30.0 * s**2 * (1.0 + s * (-2.0 + s)) / duration
            bend = 60.0 * s * (1.0 + s * (-3.0 + 2.0 * s))
            motion[2, i] = (target - here) * bend / duration**2
        now, here = now + steps, target
        rest = max(0, round(rng.uniform(dwell_time[0], dwell_time[1]) / dt))
        for i in range(now, min(now + rest, samples)):
            motion[0, i] = here
        now = now + rest
    return motion


def random_motion(
    rng: np.random.Generator,
    span: Mapping[str, tuple[float, float]],
    hold: Mapping[str, tuple[float, float]],
    samples: int,
    dt: float,
    move_time: tuple[float, float],
    dwell_time: tuple[float, float],
) -> Motion:
    """Returns angle, rate and acceleration of the whole arm, shape (samples, 4) each.

    The joints in `span` make `random_moves`, the joints in `hold` stay at a random angle, and all
    others stay at zero.
    """
    motion = np.zeros((3, samples, len(JOINTS)))
    for joint, (low, high) in span.items():
        moves = random_moves(rng, low, high, samples, dt, move_time, dwell_time)
        motion[:, :, JOINTS.index(joint)] = moves
    for joint, between in hold.items():
        motion[0, :, JOINTS.index(joint)] = rng.uniform(*between)
    return motion[0], motion[1], motion[2]


def valid_motion(motion: Motion, samples: int, ranges: Array) -> Motion:
    """Checks that an arm can be asked for an intended motion, and returns the motion.

    Args:
        motion: Angle, rate and acceleration.
        samples: Number of samples of an episode.
        ranges: Ranges of the joints [rad], shape (4, 2).

    Raises:
        InputError: The arrays are not finite, have other shapes, or leave the range of a joint.
    """
    if not isinstance(motion, list | tuple) or len(motion) != 3:
        raise InputError(
            f"the task's motion is {shown(motion)}: return angle, rate and acceleration"
        )
    angle, rate, acceleration = (np.asarray(part, dtype=float) for part in motion)
    shape, shapes = (samples, len(JOINTS)), [part.shape for part in (angle, rate, acceleration)]
    if shapes != [shape] * 3 or not _is_finite(angle, rate, acceleration):
        raise InputError(
            f"the task's motion has arrays of shape {', '.join(map(str, shapes))}: give angle, "
            f"rate and acceleration, finite numbers of shape {shape} each"
        )
    column = _out_of_range(angle, ranges, ROUNDING)
    if column >= 0:
        least, most = angle[:, column].min(), angle[:, column].max()
        low, high = ranges[column]
        raise InputError(
            f"the task's motion takes {JOINTS[column]} from {least:.3g} to {most:.3g} rad: stay "
            f"between {low:.3g} and {high:.3g} rad"
        )
    return angle, rate, acceleration


@njit(cache=True)
def _is_finite(angle: Array, rate: Array, acceleration: Array) -> bool:
    for i in range(angle.shape[0]):
        for j in range(angle.shape[1]):
            if not math.isfinite(angle[i, j] + rate[i, j] + acceleration[i, j]):
                return False
    return True


@njit(cache=True)
def _out_of_range(angle: Array, ranges: Array, rounding: float) -> int:
    """Returns the first joint that leaves its range, or -1."""
    for j in range(angle.shape[1]):
        low, high = ranges[j, 0] - rounding, ranges[j, 1] + rounding
        for i in range(angle.shape[0]):
            if not low <= angle[i, j] <= high:
                return j
    return -1
