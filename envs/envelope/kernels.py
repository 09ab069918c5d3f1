"""Kernels of the work envelope: what a posture takes, and the easiest posture for a hand position.

The hand moves in a plane that abduction turns about the axis from back to front through the
shoulder. In that plane the upper arm, the forearm and the hand are a chain of three hinges, whose
directions are angles from straight down towards forward.
"""

import math
from typing import NamedTuple

from numba import njit

from ...arrays import AnyArray, Array

ROUNDING = 1e-9  # [rad], distance by which an angle may miss its range


class Statics(NamedTuple):
    """An arm at rest, as the kernels read it; positions are in the frame of the torso.

    Attributes:
        gravity: Acceleration of free fall [m/s²], shape (3,).
        outward: 1 where abduction turns about the axis forward, -1 where backward.
        lengths: Lengths of the upper arm and of the forearm [m], shape (2,).
        grip: Distance of the grip from the wrist [m], and its direction with the wrist straight
            [rad], shape (2,).
        mass: Mass of each link with all that it wears and carries [kg], shape (4,).
        center: Its center in the frame of the link [m], shape (4, 3).
        low: Lower end of the range of each joint [rad], shape (4,).
        high: Upper end [rad], shape (4,).
        step: Distance of the angles of the tables [rad], shape (4,).
        resistance: Torque of suit and relaxed joint over the angle [N·m], shape (4, samples).
        weakest: Least torque of the wearer over the angle [N·m], shape (4, samples).
        strongest: Greatest one [N·m], the same shape.
        motor: Torque up to which a motor takes over [N·m], shape (4,).
    """

    gravity: Array
    outward: float
    lengths: Array
    grip: Array
    mass: Array
    center: Array
    low: Array
    high: Array
    step: Array
    resistance: Array
    weakest: Array
    strongest: Array
    motor: Array


@njit(cache=True)
def holding_torque(angle: AnyArray, arm: Statics, torque: AnyArray) -> None:
    """Computes the torque [N·m] that holds an arm still at every joint.

    Args:
        angle: Joint angles [rad], shape (4,).
        arm: The arm.
        torque: The result, shape (4,).
    """
    gravity, outward, lengths = arm.gravity, arm.outward, arm.lengths
    mass, center = arm.mass, arm.center
    s, c = math.sin(outward * angle[0]), math.cos(outward * angle[0])
    gx, gy, gz = gravity[0], c * gravity[1] + s * gravity[2], c * gravity[2] - s * gravity[1]
    for i in range(4):
        torque[i] = look_up(arm.resistance[i], (angle[i] - arm.low[i]) / arm.step[i])
    ex, ez = 0.0, 0.0  # the elbow, then the wrist: where the link begins
    s, c = 0.0, 1.0
    direction = 0.0
    # Where the joints are, from the shoulder on; those of abduction and flexion meet there.
    jx, jz = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    for link in range(4):
        if link > 0:
            if link > 1:
                ex, ez = ex + lengths[link - 2] * s, ez - lengths[link - 2] * c
            if link == 2:
                jx, jz = (0.0, 0.0, ex, 0.0), (0.0, 0.0, ez, 0.0)
            elif link == 3:
                jx, jz = (0.0, 0.0, jx[2], ex), (0.0, 0.0, jz[2], ez)
            direction += angle[link]
            s, c = math.sin(direction), math.cos(direction)
        x = ex + c * center[link, 0] - s * center[link, 2]
        z = ez + s * center[link, 0] + c * center[link, 2]
        y, m = center[link, 1], mass[link]
        torque[0] -= outward * m * (y * gz - z * gy)
        for joint in range(1, link + 1):
            torque[joint] += m * ((z - jz[joint]) * gx - (x - jx[joint]) * gz)


@njit(cache=True)
def look_up(table: AnyArray, place: float) -> float:
    """Returns the value between two entries of a table."""
    i = min(max(int(place), 0), table.size - 2)
    return table[i] + (place - i) * (table[i + 1] - table[i])


@njit(cache=True)
def share_of_strength(angle: AnyArray, arm: Statics, torque: AnyArray) -> float:
    """Returns the largest share of isometric strength that any joint of the wearer gives.

    Args:
        angle: Joint angles [rad], shape (4,).
        arm: The arm.
        torque: Torques from `holding_torque` [N·m], shape (4,).
    """
    motor = arm.motor
    largest = 0.0
    for i in range(4):
        left = torque[i] - min(max(torque[i], -motor[i]), motor[i])
        strength = arm.strongest[i] if left > 0.0 else arm.weakest[i]
        place = (angle[i] - arm.low[i]) / arm.step[i]
        share = left / look_up(strength, place) if left != 0.0 else 0.0
        largest = max(largest, share)
    return largest


@njit(cache=True)
def into_range(angle: float, low: float, high: float) -> float:
    """Returns the angle plus the full turns that put it into a range, or NaN."""
    turned = low - ROUNDING + (angle - low + ROUNDING) % (2.0 * math.pi)
    return min(max(turned, low), high) if turned <= high + ROUNDING else math.nan


@njit(cache=True)
def easiest_postures(
    points: AnyArray,
    wrist: AnyArray,
    arm: Statics,
    scratch: AnyArray,
    effort: AnyArray,
    posture: AnyArray,
) -> int:
    """Finds for each hand position the posture that takes the least share of strength.

    The wrist goes through its angles; shoulder and elbow then follow in closed form.

    Args:
        points: Hand positions from the shoulder, in the frame of the torso [m], shape (n, 3).
        wrist: Angles of the wrist [rad], shape (w,).
        arm: The arm.
        scratch: Angles and torques of a posture, shape (2, 4).
        effort: The least share, NaN where the hand cannot be, shape (n,).
        posture: The posture that takes it [rad], shape (n, 4).

    Returns:
        How many postures were examined.
    """
    examined, lengths, grip = 0, arm.lengths, arm.grip
    low, high, outward = arm.low, arm.high, arm.outward
    angle, torque = scratch[0], scratch[1]
    for row in range(points.shape[0]):
        x, y, z = points[row, 0], points[row, 1], points[row, 2]
        across = math.hypot(y, z)
        far = math.hypot(x, across)
        effort[row] = math.nan
        for above in range(2):
            # The hand is below the shoulder in its plane, or above it.
            plane = math.atan2(-y, z) if above else math.atan2(y, -z)
            angle[0] = into_range(outward * plane, low[0], high[0])
            if math.isnan(angle[0]):
                continue
            toward = math.atan2(x, -across if above else across)
            for w in range(wrist.size):
                angle[3] = wrist[w]
                bent = grip[1] + wrist[w]
                along, beside = lengths[1] + grip[0] * math.cos(bent), grip[0] * math.sin(bent)
                lower, turned = math.hypot(along, beside), math.atan2(beside, along)
                cosine = (far**2 - lengths[0] ** 2 - lower**2) / (2.0 * lengths[0] * lower)
                if abs(cosine) > 1.0:
                    continue
                for side in range(2):
                    fold = math.acos(cosine) if side == 0 else -math.acos(cosine)
                    angle[2] = into_range(fold - turned, low[2], high[2])
                    rise = math.atan2(lower * math.sin(fold), lengths[0] + lower * math.cos(fold))
                    angle[1] = into_range(toward - rise, low[1], high[1])
                    if math.isnan(angle[1]) or math.isnan(angle[2]):
                        continue
                    examined += 1
                    holding_torque(angle, arm, torque)
                    share = share_of_strength(angle, arm, torque)
                    if not share >= effort[row]:
                        effort[row] = share
                        posture[row] = angle
    return examined
