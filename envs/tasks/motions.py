"""Intended motions: minimum-jerk moves between random angles, or from stop to stop."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from numba import njit

from ...arrays import AnyArray, Array
from ..simulation.episode_plan import Motion

ALIKE = 1e-3  # [rad], greatest difference of angles that does not count as another motion


def minimum_jerk(fraction: AnyArray) -> tuple[Array, Array, Array]:
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

    Every move covers at least a quarter of the span, so that the suit resists noticeably. Angles
    are in rad. `move_time` and `dwell_time` are the shortest and the longest time of a move and of
    the rest after a move [s]. The motion has the shape (3, samples).
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


def through(stops: Sequence[tuple[float, Array]], samples: int, dt: float) -> Motion:
    """Returns minimum-jerk moves from stop to stop, and two derivatives.

    A stop is a time [s] and joint angles [rad] or a place [m], shape (k,). Two equal stops in turn
    are a rest; the motion stays at the first stop before, and at the last stop after all of them.
    """
    time = dt * np.arange(samples)
    motion = np.zeros((3, samples, len(stops[-1][1])))
    motion[0] = np.where((time < stops[0][0])[:, None], stops[0][1], stops[-1][1])
    for (begin, here), (end, there) in pairwise(stops):
        now = (begin <= time) & (time < end)
        shares = minimum_jerk((time[now] - begin) / (end - begin))
        for derivative, share in enumerate(shares):
            step = share[:, None] * (np.asarray(there) - here) / (end - begin) ** derivative
            motion[derivative, now] = step + (np.asarray(here) if derivative == 0 else 0.0)
    return motion[0], motion[1], motion[2]


def ramped(
    wave: AnyArray, rate: AnyArray, acceleration: AnyArray, time: AnyArray, beginning: float
) -> tuple[Array, Array, Array]:
    """Returns a wave that grows from rest within `beginning` [s], and two derivatives.

    All arrays have the shape (samples,).
    """
    grown, growth, bend = minimum_jerk(np.minimum(time / beginning, 1.0))
    growth, bend = growth / beginning, bend / beginning**2
    return (
        grown * wave,
        growth * wave + grown * rate,
        bend * wave + 2 * growth * rate + grown * acceleration,
    )


def posture(shoulder: float, elbow: float) -> Array:
    """Returns joint angles in the order of `JOINTS` [rad], 0 for the others, shape (4,)."""
    return np.array([0.0, shoulder, elbow, 0.0])


def between(windows: Sequence[tuple[float, float]], samples: int, dt: float) -> AnyArray:
    """Returns whether each sample is in a window of time [s], with both ends of the window."""
    time = dt * np.arange(samples)
    found = np.zeros(samples, np.bool_)
    for begin, end in windows:
        found |= (begin - dt / 2 <= time) & (time <= end + dt / 2)
    return found


def cycles(wait: float, period: float, duration: float) -> list[float]:
    """Returns the times at which cycles begin after a wait, until a duration has passed [s]."""
    return [wait + period * i for i in range(int(np.ceil(duration / period)) + 1)]


def distinct(motions: Iterable[AnyArray]) -> int:
    """Returns the number of motions of which no two are alike, within 1 mrad at all times.

    A motion is joint angles [rad], shape (samples, joints). A motion that ended early is compared
    with the beginning of the others.
    """
    found: list[AnyArray] = []
    for motion in motions:
        if all(_difference(motion, other) > ALIKE for other in found):
            found.append(motion)
    return len(found)


def _difference(one: AnyArray, other: AnyArray) -> float:
    samples = min(len(one), len(other))
    return float(np.abs(one[:samples] - other[:samples]).max())
