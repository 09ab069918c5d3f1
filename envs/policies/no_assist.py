"""No assist: the motors are passive."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm_env import ArmEnv


class NoAssist:
    """Commands zero torque; what remains is the wearer against suit, weight and motor friction."""

    def __init__(self, env: ArmEnv) -> None:
        self._action = np.zeros(env.wiring.motors.size)

    def reset(self) -> None:
        """Does nothing: there is no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns zero."""
        del observation, info
        return self._action.copy()
