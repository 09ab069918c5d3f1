"""Forward and inverse kinematics of the hand: four hinges in a chain."""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false

import math
from dataclasses import dataclass

import mujoco
import numpy as np
from numba import njit

from ...arrays import AnyArray, Array
from ...assets import JOINTS
from ...errors import InputError
from .inverse_dynamics import AXIS, POSITION, Chain

CLOSE = 1e-9  # [m], greatest distance between hand and place that counts as reached
CORRECTIONS = 100
FARTHEST = 0.2  # [rad], greatest change of an angle in one iteration
SOFTNESS = 1e-6  # [m²], damping of the least squares, for a stretched arm
MOVING = 3  # joints that bring the hand to a place: all but the wrist


@dataclass(frozen=True, eq=False)
class Arm:
    """The bare arm of a wearer, for the plans of tasks.

    Places are relative to the shoulder, in meters forward, outward and up, for either arm.

    Attributes:
        chain: Links of the arm.
        grip: Place of the grip in the frame of the hand [m], shape (3,).
        ranges: Ranges of the joints [rad], shape (4, 2).
        outward: +1 for a left arm, where outward is the y axis of the torso; -1 for a right arm.
        torso: Place of the torso in the world [m], shape (3,).
        turn: Rotation from the frame of the torso into the world, shape (3, 3).
    """

    chain: Chain
    grip: Array
    ranges: Array
    outward: float
    torso: Array
    turn: Array

    @classmethod
    def of(cls, arm: mujoco.MjModel, grip: Array) -> "Arm":
        """Returns the arm of a model from `bare_arm`."""
        chain = Chain.of(arm)
        outward = 1.0 if chain.links[0, 0, POSITION + 1] > 0 else -1.0
        data, torso = mujoco.MjData(arm), arm.body_parentid[arm.joint(JOINTS[0]).bodyid[0]]
        mujoco.mj_kinematics(arm, data)
        frame = data.xmat[torso].reshape(3, 3).copy()
        return cls(chain, grip, arm.jnt_range.copy(), outward, data.xpos[torso].copy(), frame)

    @property
    def length(self) -> float:
        """Distance from the shoulder to the grip of the straight arm [m]."""
        return float(np.linalg.norm(self.places(np.zeros((1, len(JOINTS))))))

    @property
    def levers(self) -> Array:
        """Distances from the joints to the grip of the straight arm [m], shape (4,)."""
        joints = np.cumsum(self.chain.links[0, :, POSITION:AXIS], axis=0)
        return np.linalg.norm(joints[-1] + self.grip - joints, axis=1)

    @property
    def gravity(self) -> Array:
        """Acceleration of free fall, forward, outward and up [m/s²], shape (3,)."""
        return self.chain.gravity[0] @ self._axes

    def places(self, angle: Array) -> Array:
        """Returns the places of the grip [m], shape (samples, 3).

        The joint angles [rad] have the shape (samples, 4).
        """
        return self.in_torso(angle) @ self._axes - self._shoulder

    def in_torso(self, angle: Array) -> Array:
        """Returns the places of the grip in the frame of the torso [m], shape (samples, 3)."""
        return self._jacobians(angle)[:, 4, :3].copy()

    def in_world(self, angle: Array) -> Array:
        """Returns the places of the grip in the world [m], shape (samples, 3)."""
        return self.torso + self.in_torso(angle) @ self.turn.T

    def from_shoulder(self, places: Array) -> Array:
        """Returns places relative to the shoulder as places in the world [m], the same shape."""
        return self.torso + (places + self._shoulder) @ self._axes @ self.turn.T

    def postures(self, places: Array, start: Array) -> Array:
        """Returns joint angles that bring the grip to places in turn [rad], shape (samples, 4).

        Places are relative to the shoulder [m], shape (samples, 3). Abduction, shoulder and elbow
        move; the wrist keeps its angle. The search for the first posture begins at `start`, shape
        (4,).
        """
        wanted = (places + self._shoulder) @ self._axes
        found = np.empty((len(places), len(JOINTS)))
        missed = follow(self.chain.links[0], self.grip, wanted, np.asarray(start, float), found)
        if missed >= 0:
            raise InputError(
                f"the place {np.round(places[missed], 3).tolist()} m from the shoulder is out of "
                f"reach: stay within {self.length:.3g} m"
            )
        low, high = self.ranges.T - [[1e-9], [-1e-9]]
        for joint, angles, least, most in zip(JOINTS, found.T, low, high, strict=True):
            if not (least <= angles.min() and angles.max() <= most):
                raise InputError(
                    f"the places take {joint} from {angles.min():.3g} to {angles.max():.3g} rad: "
                    f"stay between {least:.3g} and {most:.3g} rad"
                )
        return found

    def torque_of(self, angle: Array, force: Array) -> Array:
        """Returns the joint torques that withstand forces on the grip [N·m], shape (samples, 4).

        The torque is -J'F, with the Jacobian J of the grip and the forces F forward, outward and up
        [N], shape (samples, 3).
        """
        found, force = self._jacobians(angle), (force @ self._axes)[:, None]
        columns = np.cross(found[:, :4, :3], found[:, 4:, :3] - found[:, :4, 3:])  # per joint
        moved = columns * force
        return -(moved[..., 0] + moved[..., 1] + moved[..., 2])

    def _jacobians(self, angle: Array) -> Array:
        found = np.empty((len(angle), 5, 6))
        hand_jacobians(self.chain.links[0], self.grip, np.ascontiguousarray(angle), found)
        return found

    @property
    def _shoulder(self) -> Array:
        return self.chain.links[0, 0, POSITION:AXIS] @ self._axes

    @property
    def _axes(self) -> Array:
        return np.diag([1.0, self.outward, 1.0])


@njit(cache=True)
def hand_jacobian(
    links: AnyArray, grip: AnyArray, angle: AnyArray, sample: int, found: AnyArray
) -> None:
    """Computes place and Jacobian of the grip in the frame of the torso, at a sample of angles.

    `found`, shape (5, 6), gets axis and origin of each joint, then the grip [m] in the first three
    places of the last row.
    """
    for k in range(3):
        # Row k of the rotation from the frame of the link into that of the torso, and its origin.
        x, y = 1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0
        z, origin = 1.0 if k == 2 else 0.0, 0.0
        for i in range(4):
            px, py, pz = links[i, POSITION], links[i, POSITION + 1], links[i, POSITION + 2]
            ux, uy, uz = links[i, AXIS], links[i, AXIS + 1], links[i, AXIS + 2]
            origin = origin + x * px + y * py + z * pz
            found[i, k], found[i, 3 + k] = x * ux + y * uy + z * uz, origin
            s, c = math.sin(angle[sample, i]), math.cos(angle[sample, i])
            d = 1.0 - c
            x, y, z = (  # Rodrigues' rotation about u
                x * (c + d * ux * ux) + y * (d * uy * ux + s * uz) + z * (d * uz * ux - s * uy),
                x * (d * ux * uy - s * uz) + y * (c + d * uy * uy) + z * (d * uz * uy + s * ux),
                x * (d * ux * uz + s * uy) + y * (d * uy * uz - s * ux) + z * (c + d * uz * uz),
            )
        found[4, k] = origin + x * grip[0] + y * grip[1] + z * grip[2]


@njit(cache=True)
def column(found: AnyArray, joint: int, into: AnyArray) -> None:
    """Writes the velocity of the grip per rate of a joint [m], from `hand_jacobian`."""
    ux, uy, uz = found[joint, 0], found[joint, 1], found[joint, 2]
    rx, ry, rz = (
        found[4, 0] - found[joint, 3],
        found[4, 1] - found[joint, 4],
        found[4, 2] - found[joint, 5],
    )
    into[0], into[1], into[2] = uy * rz - uz * ry, uz * rx - ux * rz, ux * ry - uy * rx


@njit(cache=True)
def hand_jacobians(links: AnyArray, grip: AnyArray, angle: AnyArray, found: AnyArray) -> None:
    """Computes `hand_jacobian` at all samples, shape (samples, 5, 6)."""
    for i in range(angle.shape[0]):
        hand_jacobian(links, grip, angle, i, found[i])


@njit(cache=True)
def follow(
    links: AnyArray, grip: AnyArray, wanted: AnyArray, start: AnyArray, angle: AnyArray
) -> int:
    """Computes postures that bring the grip to places; returns the first place out of reach, or -1.

    The method is damped least squares (Wampler 1986, Nakamura and Hanafusa 1986), which starts at
    the last posture.
    """
    found, jacobian = np.empty((5, 6)), np.empty((MOVING, 3))
    left, matrix = np.empty(3), np.empty((MOVING, MOVING))
    for i in range(wanted.shape[0]):
        for j in range(4):
            angle[i, j] = start[j] if i == 0 else angle[i - 1, j]
        reached = False
        for _ in range(CORRECTIONS):
            hand_jacobian(links, grip, angle, i, found)
            far = 0.0
            for k in range(3):
                left[k] = wanted[i, k] - found[4, k]
                far = max(far, abs(left[k]))
            if far < CLOSE:
                reached = True
                break
            for j in range(MOVING):
                column(found, j, jacobian[j])
            matrix[:] = jacobian @ jacobian.T
            for j in range(MOVING):
                matrix[j, j] += SOFTNESS * min(1.0, far)
            turn = np.linalg.solve(matrix, jacobian @ left)
            largest = max(np.abs(turn).max(), FARTHEST)
            for j in range(MOVING):
                angle[i, j] += turn[j] * FARTHEST / largest
        if not reached:
            return i
    return -1


def through_places(arm: Arm, places: Array, start: Array, dt: float) -> tuple[Array, Array, Array]:
    """Returns the motion whose grip goes through places that are `dt` apart."""
    from scipy.interpolate import CubicSpline  # slow to import

    angle = arm.postures(places, start)
    spline = CubicSpline(dt * np.arange(len(angle)), angle)
    time = spline.x
    return angle, spline(time, 1), spline(time, 2)
