"""The oracle: the motors cancel the true suit torque, which no real device can measure."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assets import JOINTS
from ..arm_env import ArmEnv
from ..composition import ASSISTED


class Oracle:
    """Commands minus the suit torque of this instant; the motors' own delay remains."""

    def __init__(self, env: ArmEnv) -> None:
        self._columns, self._peak = [JOINTS.index(joint) for joint in ASSISTED], env.peak_torque

    def reset(self) -> None:
        """Does nothing: there is no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the suit torque, reversed, over the peak, clipped to [-1, 1]."""
        del observation
        return np.clip(-info["suit_torque"][self._columns] / self._peak, -1, 1)
