"""The posture of our arm in the joint angles of MyoArm, and the axes that both share.

Vectors are forward, up and right of the trunk. Our shoulder turns by abduction, then by flexion,
and the humerus does not turn about itself. MyoArm has a plane of elevation, an elevation in it, and
a rotation of the humerus: the upper arm swings in the plane and turns about itself, and an
orientation of ours has one answer in these angles in closed form. In the hanging arm the plane of
elevation is not defined; elevations below `LEAST` are therefore raised to it.

Muscles give torque about seven axes. The third is neither ours nor MyoArm's: it is perpendicular to
our first two. Where the arm points forward the humerus lies on the axis of abduction, so that
abduction and rotation of the humerus are one axis, and a torque about both says the same twice. The
perpendicular axis says what is missing in every posture.
"""

import numpy as np

from ...arrays import Array

AXES = (
    *("abduction", "shoulder flexion", "shoulder's third axis", "elbow flexion"),
    *("pronation", "wrist flexion", "wrist deviation"),
)
"""Axes about which muscles give torque, in the order of all arrays of this package."""

OWN = (0, 1, 3, 5)
"""Axes that our four joints turn about, in the order of `JOINTS`."""

THIRD = 2
LEAST = 1e-3  # [rad], least elevation


def turn(axis: int, angle: Array) -> Array:
    """Returns rotations about a coordinate axis, shape (samples, 3, 3)."""
    found = np.zeros((len(angle), 3, 3))
    one, other = (axis + 1) % 3, (axis + 2) % 3
    found[:, axis, axis] = 1
    found[:, one, one] = found[:, other, other] = np.cos(angle)
    found[:, other, one] = np.sin(angle)
    found[:, one, other] = -found[:, other, one]
    return found


def shoulder(angle: Array) -> Array:
    """Returns plane of elevation, elevation and rotation for our joint angles [rad].

    Args:
        angle: Our joint angles [rad], shape (samples, 4).

    Returns:
        The angles, shape (samples, 3).
    """
    hanging = np.hypot(angle[:, 0], angle[:, 1]) < LEAST
    flexion = np.where(hanging, LEAST, angle[:, 1])
    return decomposed(turn(0, -angle[:, 0]) @ turn(2, flexion))


def decomposed(whole: Array) -> Array:
    """Returns plane of elevation, elevation and rotation of upper arms [rad], shape (samples, 3).

    Args:
        whole: Orientations of the upper arm, 1 where it hangs, shape (samples, 3, 3).
    """
    along = -whole[:, :, 1]
    elevation = np.arctan2(np.hypot(along[:, 0], along[:, 2]), -along[:, 1])
    plane = np.arctan2(along[:, 0], along[:, 2])
    swing = turn(1, plane) @ turn(0, -elevation) @ turn(1, -plane)
    twist = np.swapaxes(swing, 1, 2) @ whole
    return np.stack([plane, elevation, np.arctan2(twist[:, 0, 2], twist[:, 2, 2])], axis=1)


def shoulder_rates(angle: Array, theirs: Array) -> Array:
    """Returns the rates of MyoArm's shoulder angles for a turning of 1 rad/s about each axis.

    Args:
        angle: Our joint angles [rad], shape (samples, 4).
        theirs: The same posture from `shoulder` [rad], shape (samples, 3).

    Returns:
        The rates, shape (samples, 3, 3): angles of MyoArm, axes of `AXES`.
    """
    axes = shoulder_axes(angle)
    plane, elevation, _ = theirs.T
    up = np.broadcast_to([0.0, 1.0, 0.0], (len(angle), 3))
    humerus = (turn(1, plane) @ turn(0, -elevation))[:, :, 1]
    columns = np.stack([up - humerus, -turn(1, plane)[:, :, 0], humerus], axis=2)
    return np.asarray(np.linalg.solve(columns, axes), np.float64)


def shoulder_axes(angle: Array) -> Array:
    """Returns the three axes of the shoulder as columns, shape (samples, 3, 3)."""
    abduction = np.broadcast_to([-1.0, 0.0, 0.0], (len(angle), 3))
    flexion = turn(0, -angle[:, 0])[:, :, 2]
    return np.stack([abduction, flexion, np.cross(abduction, flexion)], axis=2)
