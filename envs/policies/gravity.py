"""Gravity compensation: the motors carry the weight of arm, suit and exoskeleton."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..arm_env import ArmEnv


class GravityCompensation:
    """Cancels the static gravity torque at the measured joint angles, from the known masses."""

    def __init__(self, env: ArmEnv) -> None:
        self._model, self._data = env.model, mujoco.MjData(env.model)
        self._wiring, self._angle = env.wiring, env.layout["angle"]
        self._assisted = env.wiring.joints[env.wiring.assisted]
        self._bias = np.zeros(env.model.nv)

    def reset(self) -> None:
        """Does nothing: there is no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the torque that holds the arm still, over the peak, clipped to [-1, 1]."""
        del info
        self._data.qpos[self._wiring.joints] = observation[self._angle]
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_rne(self._model, self._data, 0, self._bias)
        return np.clip(self._bias[self._assisted] / self._wiring.peak_torque, -1, 1)
