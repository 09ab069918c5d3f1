"""Gravity compensation: the motors carry the weight of arm, suit, exoskeleton and load."""

from typing import ClassVar

import mujoco
import numpy as np
from numpy.typing import NDArray

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
        addresses = episodes.simulation.addresses
        self._model = episodes.simulation.model
        self._data = mujoco.MjData(self._model)
        self._addresses, self._angle = addresses, episodes.observer.layout["angle"]
        chains = np.unique([addresses.joints, addresses.exo_joints], axis=0)
        self._assisted = chains[:, addresses.assisted]
        self._bias = np.zeros(self._model.nv)

    def reset(self) -> None:
        """Does nothing, because the policy has no memory."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the torque that holds the arm, divided by the peak and clipped to [-1, 1]."""
        angles = observation[..., self._angle]
        weight = [self._weight(angle) for angle in angles.reshape(-1, angles.shape[-1])]
        share = np.array(weight).reshape(*angles.shape[:-1], -1) / self._addresses.peak_torque
        return np.clip(share, -1, 1)

    def _weight(self, angle: NDArray[np.float32]) -> NDArray[np.float64]:
        data, addresses = self._data, self._addresses
        data.qpos[addresses.joints] = data.qpos[addresses.exo_joints] = angle
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_comPos(self._model, data)
        mujoco.mj_rne(self._model, data, 0, self._bias)
        return self._bias[self._assisted].sum(axis=0)
