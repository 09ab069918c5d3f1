"""The oracle: the motors cancel the true suit torque, which no real device can measure."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from .base import Arms


class Oracle:
    """Commands the opposite of the present suit torque; only the delay of the motors remains.

    Args:
        env: Environment in which the policy acts, single or vector.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders", "privileged")

    def __init__(self, env: Arms) -> None:
        addresses = env.episodes.simulation.addresses
        begin = env.episodes.observer.layout["suit_torque"].start
        self._assisted, self._peak = begin + addresses.assisted, addresses.peak_torque

    def reset(self) -> None:
        """Does nothing, because the policy has no memory."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns minus the suit torque, divided by the peak and clipped to [-1, 1]."""
        resisting = -observation[..., self._assisted].astype(np.float64)
        return np.clip(resisting / self._peak, -1, 1)
