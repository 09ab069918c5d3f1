"""The inertia of an arm that a controller believes in, and its momentum."""

import copy

import mujoco
import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ..model import ASSISTED
from .torque import chains
from .trigonometric import Trigonometric

ASSISTED_PLACES = [JOINTS.index(joint) for joint in ASSISTED]
BENT = (0.0, 0.0, np.pi / 2, 0.0)  # rad, hanging upper arm and level forearm


class BelievedInertia:
    """The mass matrix of an arm with all that it wears and carries, at any pose.

    The matrix depends on the joints below the first one alone, by products of their sines and
    cosines of degree 2 (see `Trigonometric`).

    Args:
        model: Model of the believed arm; where cuffs hold the exoskeleton, its joints are taken at
            the same angles as the arm's.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        data, places = mujoco.MjData(model), chains(model)
        full = np.empty((model.nv, model.nv))

        def at(pose: Array) -> Array:
            for chain in places:
                data.qpos[chain[1:]] = pose
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_makeM(model, data)
            mujoco.mj_fullM(model, data, full)
            return np.sum([full[chain[:, None], chain] for chain in places], axis=0)

        self._matrix = Trigonometric(at, len(JOINTS) - 1, 2)

    def __sub__(self, other: "BelievedInertia") -> "BelievedInertia":
        """Returns the inertia of what one model has and the other has not."""
        rest = copy.copy(self)
        rest._matrix = self._matrix - other._matrix
        return rest

    def __call__(self, angle: Array) -> Array:
        """Returns the mass matrix [kg·m²], shape (n, 4, 4).

        Args:
            angle: Angles of the four joints [rad], shape (n, 4).
        """
        return self._matrix(angle[:, 1:])

    def nominal(self) -> Array:
        """Returns what each assisted joint moves alone where the elbow is bent [kg·m²], (2,)."""
        matrix = self(np.array([BENT]))[0]
        return matrix[ASSISTED_PLACES, ASSISTED_PLACES]

    def momentum(self, angle: Array, rate: Array) -> tuple[Array, Array]:
        """Returns generalized momentum of the assisted joints, and its rate due to motion.

        The momentum p = M q' changes by the torques on the arm and by C'q', which is half the
        derivative of q'M q' with respect to the joint's angle.

        Args:
            angle: Angles of the four joints [rad], shape (n, 4).
            rate: Their rates [rad/s], the same shape.

        Returns:
            The momentum [N·m·s], and C'q' [N·m], shape (n, 2) each.
        """
        momentum = (self(angle)[:, ASSISTED_PLACES] * rate[:, None]).sum(-1)
        squares = (rate[:, :, None] * rate[:, None]).reshape(len(rate), -1)
        gyration = np.empty_like(momentum)
        for i, joint in enumerate(ASSISTED_PLACES):
            slope = self._matrix(angle[:, 1:], slope=joint - 1).reshape(squares.shape)
            gyration[:, i] = (slope * squares).sum(-1) / 2
        return momentum, gyration
