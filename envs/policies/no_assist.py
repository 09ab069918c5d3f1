"""No assist: the motors give no torque."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm_env import ArmEnv


class NoAssist:
    """Commands zero torque: the wearer alone works against suit, weight and motor friction."""

    def __init__(self, env: ArmEnv) -> None:
        self._action = np.zeros(env.wiring.motors.size)

    def reset(self) -> None:
        """Does nothing, because the policy has no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns zeros."""
        del observation, info
        return self._action.copy()
