"""The posture of our arm in the joint angles of MyoArm, and the axes that both arms share.

Vectors are forward, up and right of the trunk. Our shoulder turns by abduction, then by flexion,
and the humerus does not turn about itself. MyoArm has a plane of elevation, an elevation in it, and
a rotation of the humerus: the upper arm swings in the plane and turns about itself, and each
orientation of our arm follows in these angles in closed form. In the hanging arm the plane of
elevation is not defined; elevations below `LEAST` are therefore set to `LEAST`.

Muscles give torque about seven axes. The third axis is perpendicular to our first two, and no joint
axis of MyoArm. Where the arm points forward the humerus lies on the axis of abduction, so that
abduction and rotation of the humerus are one axis, and torques about both are one number. The
perpendicular axis completes the three torques in every posture.

A hinge carries every moment across its axis. In a body muscles, bones and ligaments, or an
exoskeleton must give this moment. The wearer gives the moments of the limb, of the suit on the limb
and of the load in the hand; an exoskeleton carries the moments of its own parts in its bearings.
Suit and motors act about our four axes only.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from ...arrays import Array
from ..simulation.inverse_dynamics import AXIS, CENTER, INERTIA, MASS, POSITION, STIFFNESS, Chain

AXES = (
    *("abduction", "shoulder flexion", "shoulder's third axis", "elbow flexion"),
    *("pronation", "wrist flexion", "wrist deviation"),
)
"""Axes about which muscles give torque, in the order of all arrays of this package."""

OWN = (0, 1, 3, 5)
"""Axes that our four joints turn about, in the order of `JOINTS`."""

THIRD = 2
LEAST = 1e-3  # [rad], least elevation
_TO_BODY = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""Forward, up and right from the frame of the torso, which is forward, left and up."""


def turn(axis: int, angle: Array) -> Array:
    """Returns rotations about a coordinate axis, shape (samples, 3, 3)."""
    return _about(np.eye(3)[axis], angle)


def shoulder(angle: Array) -> Array:
    """Returns plane of elevation, elevation and rotation of our joint angles (samples, 4) [rad]."""
    hanging = np.hypot(angle[:, 0], angle[:, 1]) < LEAST
    flexion = np.where(hanging, LEAST, angle[:, 1])
    return decomposed(turn(0, -angle[:, 0]) @ turn(2, flexion))


def decomposed(whole: Array) -> Array:
    """Returns plane of elevation, elevation and rotation of orientations (samples, 3, 3) [rad].

    The orientation of a hanging upper arm is the identity.
    """
    along = -whole[:, :, 1]
    elevation = np.arctan2(np.hypot(along[:, 0], along[:, 2]), -along[:, 1])
    plane = np.arctan2(along[:, 0], along[:, 2])
    swing = turn(1, plane) @ turn(0, -elevation) @ turn(1, -plane)
    twist = np.swapaxes(swing, 1, 2) @ whole
    return np.stack([plane, elevation, np.arctan2(twist[:, 0, 2], twist[:, 2, 2])], axis=1)


def shoulder_rates(angle: Array, theirs: Array) -> Array:
    """Returns the rates of MyoArm's shoulder angles for a turn at 1 rad/s about each of our axes.

    The posture is given as our angles [rad], shape (samples, 4), and as `shoulder` returns it. The
    rates have the shape (samples, 3, 3): angles of MyoArm, axes of `AXES`.
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


def constraint_torques(
    chain: Chain, angle: Array, rate: Array, acceleration: Array
) -> tuple[Array, Array]:
    """Returns the torques that move an arm along a motion, about all seven axes of `AXES`.

    Angles [rad], rates [rad/s] and accelerations [rad/s²] have the shape (samples, 4). Returned are
    the torques [N·m], shape (samples, 7), and the axes (forward, up, right), (samples, 7, 3).
    """
    moment, links = _moments(_right(chain), angle, rate, acceleration)
    abduction, flexion, elbow, wrist = np.moveaxis(links[:, :, :, 0], 1, 0)
    forearm, hand = links[:, 2, :, 1], links[:, 3, :, 1]
    axes = np.stack(
        [
            *(abduction, flexion, np.cross(abduction, flexion)),
            *(elbow, forearm, wrist, np.cross(hand, wrist)),
        ],
        axis=1,
    )
    about = moment[:, [0, 0, 0, 2, 2, 3, 3]]
    return (axes * about).sum(axis=2), axes @ _TO_BODY.T


def _right(chain: Chain) -> Chain:
    """Returns a left arm as a right one, its mirror image."""
    if chain.links[0, 0, POSITION + 1] < 0:
        return chain
    links, aside = chain.links.copy(), np.array([1.0, -1.0, 1.0])
    links[..., POSITION:AXIS] *= aside
    links[..., AXIS:MASS] *= -aside  # an axis of rotation is a pseudovector
    links[..., CENTER:INERTIA] *= aside
    links[..., INERTIA:STIFFNESS] *= [1, 1, 1, -1, 1, -1]
    return replace(chain, links=links, gravity=chain.gravity * aside)


def _moments(chain: Chain, angle: Array, rate: Array, acceleration: Array) -> tuple[Any, Any]:
    """Returns the moment at each joint, and axis and direction of the link below, in the torso.

    The Newton-Euler equations link by link; `simulation.inverse_dynamics` has these in scalars for
    the four joint axes alone.
    """
    links, samples = chain.links[0], len(angle)
    turning, spun = np.zeros((samples, 3)), np.zeros((samples, 3))
    pull = np.broadcast_to(-chain.gravity[0], (samples, 3))  # acceleration of the joint's origin
    frame = np.broadcast_to(np.eye(3), (samples, 3, 3))
    arms, forces, moments, found = [], [], [], []
    for i, link in enumerate(links):
        arm, axis = frame @ link[POSITION:AXIS], frame @ link[AXIS:MASS]
        pull = pull + np.cross(spun, arm) + np.cross(turning, np.cross(turning, arm))
        speed, change = rate[:, i, None], acceleration[:, i, None]
        spun = spun + axis * change + np.cross(turning, axis) * speed
        turning = turning + axis * speed
        frame = frame @ _about(link[AXIS:MASS], angle[:, i])
        center = frame @ link[CENTER:INERTIA]
        xx, yy, zz, xy, xz, yz = link[INERTIA:STIFFNESS]
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        inertia = frame @ own @ np.swapaxes(frame, 1, 2)
        force = link[MASS] * (
            pull + np.cross(spun, center) + np.cross(turning, np.cross(turning, center))
        )
        swirl = np.einsum("nij,nj->ni", inertia, turning)
        moment = np.einsum("nij,nj->ni", inertia, spun) + np.cross(turning, swirl)
        arms.append(arm)
        forces.append(force)
        moments.append(moment + np.cross(center, force))
        found.append(np.stack([axis, frame[:, :, 2]], axis=2))
    total, bend, at_joints = np.zeros((samples, 3)), np.zeros((samples, 3)), []
    for arm, force, moment in zip(arms[::-1], forces[::-1], moments[::-1], strict=True):
        total, bend = total + force, bend + moment
        at_joints.append(bend)
        bend = bend + np.cross(arm, total)
    return np.stack(at_joints[::-1], axis=1), np.stack(found, axis=1)


def _about(axis: Array, angle: Array) -> Array:
    """Returns rotations about a unit vector (Rodrigues), shape (samples, 3, 3)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * cross + (1 - c) * (cross @ cross)
