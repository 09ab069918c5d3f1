"""The oracle: the motors cancel the true suit torque, which no real device can measure."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm_env import ArmEnv


class Oracle:
    """Commands minus the suit torque of this instant; the motors' own delay remains."""

    def __init__(self, env: ArmEnv) -> None:
        self._wiring = env.wiring

    def reset(self) -> None:
        """Does nothing: there is no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the suit torque, reversed, over the peak, clipped to [-1, 1]."""
        del observation
        wiring = self._wiring
        return np.clip(-info["suit_torque"][wiring.assisted] / wiring.peak_torque, -1, 1)
