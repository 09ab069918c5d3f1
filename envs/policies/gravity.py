"""Gravity compensation: the motors carry the weight of arm, suit, exoskeleton and load."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from ..arm_env import ArmEnv


class GravityCompensation:
    """Cancels the static gravity torque at the measured joint angles, computed from known masses.

    With cuffs it uses the exoskeleton's angles for the arm's; they differ because cuffs yield.
    """

    def __init__(self, env: ArmEnv) -> None:
        self._model, self._data = env.model, mujoco.MjData(env.model)
        self._wiring, self._angle = env.wiring, env.layout["angle"]
        chains = np.unique([env.wiring.joints, env.wiring.exo_joints], axis=0)
        self._assisted = chains[:, env.wiring.assisted]
        self._bias = np.zeros(env.model.nv)

    def reset(self) -> None:
        """Does nothing, because the policy has no memory."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the torque that holds the arm, divided by the peak and clipped to [-1, 1]."""
        del info
        angle = observation[self._angle]
        self._data.qpos[self._wiring.joints] = self._data.qpos[self._wiring.exo_joints] = angle
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_comPos(self._model, self._data)
        mujoco.mj_rne(self._model, self._data, 0, self._bias)
        weight = self._bias[self._assisted].sum(axis=0)
        return np.clip(weight / self._wiring.peak_torque, -1, 1)
