"""Intended motions: minimum-jerk moves between random targets, and the wearer's feed-forward."""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..assets import JOINTS, SuitJoint
from ..errors import InputError

ROUNDING = 1e-9  # rad, which an intention may be beyond the range of a joint


@dataclass(frozen=True, eq=False)
class Reference:
    """The motion that the wearer intends, at the control rate, shape (samples, joints) each.

    Attributes:
        angle: Intended joint angles [rad].
        rate: Rates of the intended angles [rad/s].
        feedforward: Torque that moves the bare arm along the motion [N·m].
        resistance: Resistance of the suit along the motion [N·m]; zeros for a wearer who has not
            learned any of it.
    """

    angle: Array
    rate: Array
    feedforward: Array
    resistance: Array

    def at(self, step: int) -> int:
        """Returns the sample of control period `step`, and the last sample after the end."""
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

    Every move covers at least a quarter of the span, so that the suit resists noticeably.
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


def random_motion(
    rng: np.random.Generator,
    span: Mapping[str, tuple[float, float]],
    hold: Mapping[str, tuple[float, float]],
    samples: int,
    dt: float,
    move_time: tuple[float, float],
    dwell_time: tuple[float, float],
) -> tuple[Array, Array, Array]:
    """Returns angle, rate and acceleration of the whole arm, shape (samples, joints) each.

    The joints in `span` make `random_moves`, the joints in `hold` stay at a random angle, and all
    others stay at zero.
    """
    motion = np.zeros((3, samples, len(JOINTS)))
    for joint, between in span.items():
        moves = random_moves(rng, between, samples, dt, move_time, dwell_time)
        motion[:, :, JOINTS.index(joint)] = moves
    for joint, between in hold.items():
        motion[0, :, JOINTS.index(joint)] = rng.uniform(*between)
    return motion[0], motion[1], motion[2]


def valid_motion(
    motion: tuple[Array, Array, Array], samples: int, ranges: Array
) -> tuple[Array, Array, Array]:
    """Checks that an arm can be asked for an intended motion, and returns the motion.

    Args:
        motion: Angle, rate and acceleration.
        samples: Number of samples of an episode.
        ranges: Ranges of the joints [rad], shape (joints, 2).

    Raises:
        InputError: The arrays are not finite, have other shapes, or leave the range of a joint.
    """
    parts = [np.asarray(part, dtype=float) for part in motion]
    shape, shapes = (samples, len(JOINTS)), [part.shape for part in parts]
    if shapes != [shape] * 3 or not np.isfinite(parts).all():
        raise InputError(
            f"intended_motion returned arrays of shape {', '.join(map(str, shapes))}: give angle, "
            f"rate and acceleration, finite numbers of shape {shape} each"
        )
    angle, rate, acceleration = parts
    for joint, column, (low, high) in zip(JOINTS, angle.T, ranges.tolist(), strict=True):
        if column.min() < low - ROUNDING or column.max() > high + ROUNDING:
            raise InputError(
                f"intended_motion takes {joint} from {column.min():.3g} to {column.max():.3g} rad: "
                f"stay between {low:.3g} and {high:.3g} rad"
            )
    return angle, rate, acceleration


def follow(
    arm: mujoco.MjModel,
    indices: NDArray[np.int64],
    motion: tuple[Array, Array, Array],
    known: Mapping[str, SuitJoint] | None = None,
) -> Reference:
    """Returns the reference for a motion (angle, rate, acceleration), shape (samples, joints).

    The feed-forward is the inverse dynamics of the wearer's own arm, which a person has learned;
    the exoskeleton's dynamics are not part of it.

    Args:
        arm: Model of the wearer's arm alone, from `bare_arm`.
        indices: Indices of the joints in its qpos.
        motion: Intended angle, rate and acceleration.
        known: Joints of the suit that the wearer has learned to foresee.
    """
    angle, rate, acceleration = motion
    data = mujoco.MjData(arm)
    torque = np.empty_like(angle)
    for i in range(len(angle)):
        data.qpos[indices], data.qvel[indices] = angle[i], rate[i]
        data.qacc[indices] = acceleration[i]
        mujoco.mj_inverse(arm, data)
        torque[i] = data.qfrc_inverse[indices]
    return Reference(angle, rate, torque, _resistance(known or {}, angle))


def _resistance(joints: Mapping[str, SuitJoint], angle: Array) -> Array:
    torque = np.zeros_like(angle)
    for joint, entry in joints.items():
        column = JOINTS.index(joint)
        motion = np.append(entry.start_angle, angle[:, column])
        torque[:, column] = entry.model.response(motion, entry.start_torque)[1:]
    return torque
