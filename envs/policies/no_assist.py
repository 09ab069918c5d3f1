"""No assist: the motors give no torque."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from .base import Arms


class NoAssist:
    """Commands zero torque: the wearer alone works against suit, weight and motor friction.

    Args:
        env: Environment in which the policy acts, single or vector.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, env: Arms) -> None:
        self._motors = env.episodes.motors

    def reset(self) -> None:
        """Does nothing, because the policy has no memory."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns zeros."""
        return np.zeros((*observation.shape[:-1], self._motors))
