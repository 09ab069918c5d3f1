"""The oracle: the motors cancel the true suit torque, which no real device can measure."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm_env import ArmEnv


class Oracle:
    """Commands the opposite of the present suit torque; only the delay of the motors remains."""

    def __init__(self, env: ArmEnv) -> None:
        self._wiring = env.wiring

    def reset(self) -> None:
        """Does nothing, because the policy has no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns minus the suit torque, divided by the peak and clipped to [-1, 1]."""
        del observation
        wiring = self._wiring
        return np.clip(-info["suit_torque"][wiring.assisted] / wiring.peak_torque, -1, 1)
