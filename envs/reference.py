"""Intended motions: minimum-jerk moves between random targets, and the wearer's feed-forward."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Reference:
    """What the wearer intends, sampled at the control rate, shape (samples, joints) each.

    Attributes:
        angle: intended joint angles [rad].
        rate: their derivatives [rad/s].
        feedforward: torque that moves the bare arm along them [N·m].
    """

    angle: Array
    rate: Array
    feedforward: Array

    def at(self, step: int) -> int:
        """Returns the sample of control period `step`: the last one past the end."""
        return min(step, len(self.angle) - 1)


def minimum_jerk(fraction: Array) -> tuple[Array, Array, Array]:
    """Returns 10 s^3 - 15 s^4 + 6 s^5 and its first two derivatives for s in [0, 1]."""
    s = fraction
    position = s**3 * (10 + s * (-15 + 6 * s))
    rate = 30 * s**2 * (1 + s * (-2 + s))
    acceleration = 60 * s * (1 + s * (-3 + 2 * s))
    return position, rate, acceleration


def random_moves(
    rng: np.random.Generator,
    span: tuple[float, float],
    samples: int,
    dt: float,
    move_time: tuple[float, float],
    dwell_time: tuple[float, float],
) -> tuple[Array, Array, Array]:
    """Returns angle, rate and acceleration of minimum-jerk moves between random targets in `span`.

    Every move covers at least a quarter of the span, so that the suit is really worked.
    """
    low, high = span
    least = (high - low) / 4
    angle, rate, acceleration = np.empty((3, samples))
    here, now = rng.uniform(low, high), 0
    while now < samples:
        target = rng.uniform(low, high)
        while abs(target - here) < least:
            target = rng.uniform(low, high)
        steps = max(1, round(rng.uniform(*move_time) / dt))
        duration = steps * dt
        part = slice(now, min(now + steps, samples))
        s, v, w = minimum_jerk((np.arange(now, part.stop) - now) / steps)
        angle[part] = here + (target - here) * s
        rate[part] = (target - here) * v / duration
        acceleration[part] = (target - here) * w / duration**2
        now, here = now + steps, target
        rest = slice(now, min(now + round(rng.uniform(*dwell_time) / dt), samples))
        angle[rest], rate[rest], acceleration[rest] = here, 0.0, 0.0
        now = max(now, rest.stop)
    return angle, rate, acceleration


def follow(
    arm: mujoco.MjModel, indices: NDArray[np.int64], motion: tuple[Array, Array, Array]
) -> Reference:
    """Returns the reference for a motion (angle, rate, acceleration), shape (samples, joints).

    The feed-forward is the inverse dynamics of the wearer's own arm: a person has learned that,
    but neither the suit nor the exoskeleton.
    """
    angle, rate, acceleration = motion
    data = mujoco.MjData(arm)
    torque = np.empty_like(angle)
    for i in range(len(angle)):
        data.qpos[indices], data.qvel[indices] = angle[i], rate[i]
        data.qacc[indices] = acceleration[i]
        mujoco.mj_inverse(arm, data)
        torque[i] = data.qfrc_inverse[indices]
    return Reference(angle, rate, torque)
