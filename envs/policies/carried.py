"""What the arm carries, as an observer of disturbances sees it: momentum, and torques upon it."""

import numpy as np

from ...arrays import Array
from ..belief import Belief
from ..belief.inertia import ASSISTED_PLACES
from ..plant import Plant
from .base import Seen
from .model_based import friction_of


class Carried:
    """Believed momentum of suit, exoskeleton and load, and the torques upon them that are known.

    Unknown are the suit's torque and the person's, which `person` measures.

    The bare arm is no part of it: `interaction_torque` is what the person gives beyond what the
    bare arm needs, and moves these alone.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
    """

    def __init__(self, plant: Plant, belief: Belief | None) -> None:
        arm = plant.believed(belief)
        self._inertia, self._weight = arm.carried_inertia(), arm.carried_weight()
        self._friction = friction_of(arm.config.exo, 1.0, viscous=False)
        self._peak = np.array([motor.peak_torque for motor in arm.config.exo.motors.values()])

    def __call__(self, seen: Seen) -> tuple[Array, Array]:
        """Returns the momentum [N·m·s] and the torque that is known [N·m], shape (n, 2) each.

        The torque is that of motors and weight, less friction.
        """
        angle, rate = seen["angle"], seen["rate"]
        momentum, gyration = self._inertia.momentum(angle, rate)
        given = seen["motor_torque"] * self._peak - self._friction(rate[:, ASSISTED_PLACES])
        return momentum, gyration - self._weight(angle) + given


def person(seen: Seen) -> Array:
    """Returns the torque that the person gives to what is carried [N·m], shape (n, 2)."""
    return seen["interaction_torque"][:, ASSISTED_PLACES]
