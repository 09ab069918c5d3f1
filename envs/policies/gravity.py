"""Gravity compensation: the motors carry the weight of arm, suit, exoskeleton and load."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..belief import BelievedWeight
from .base import Arms


class GravityCompensation:
    """Cancels the static gravity torque at the measured joint angles, computed from known masses.

    With cuffs it uses the exoskeleton's angles for the arm's; they differ because cuffs yield.

    Args:
        env: Environment in which the policy acts, single or vector.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, env: Arms) -> None:
        episodes = env.episodes
        self._weight = BelievedWeight(episodes.simulation.model)
        self._peak = episodes.simulation.addresses.peak_torque
        self._angle = episodes.observer.layout["angle"]

    def reset(self) -> None:
        """Does nothing, because the policy has no memory."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the torque that holds the arm, divided by the peak and clipped to [-1, 1]."""
        angle = observation[..., self._angle].astype(np.float64)
        torque = self._weight(angle.reshape(-1, angle.shape[-1]))
        return np.clip(torque / self._peak, -1, 1).reshape(*angle.shape[:-1], -1)
