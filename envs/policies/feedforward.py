"""Hysteresis feed-forward: the motors cancel the suit torque that an identified model predicts."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...assets import SuitJoint
from ..arm_env import ArmEnv
from ..model import ASSISTED


class HysteresisFeedforward:
    """Predicts the suit torque by a model that keeps its own memory of the motion.

    The memory follows the measured angle. The command is the model's torque one preview ahead, at
    the measured angle plus the change of the target until then. The preview makes up for the delay
    of the motors, and shows a reversal before it comes.

    Args:
        env: Environment in which the policy acts.
        joints: Joints of the suit that the controller believes in, which need not be the simulated
            suit; a joint that is missing gets no assist.
    """

    def __init__(self, env: ArmEnv, joints: Mapping[str, SuitJoint]) -> None:
        entries = {i: joints[name] for i, name in enumerate(ASSISTED) if name in joints}
        self._models = {i: entry.model for i, entry in entries.items()}
        self._starts = {
            i: entry.model.start(entry.start_angle, entry.start_torque)
            for i, entry in entries.items()
        }
        angle, target = env.layout["angle"], env.layout["target"]
        self._measured = angle.start + env.wiring.assisted
        self._target = [target.start + i for i in range(len(ASSISTED))]  # the nearest preview
        self._columns = env.wiring.assisted
        self._peak = env.wiring.peak_torque
        self.reset()

    def reset(self) -> None:
        """Resets the memory to the state in which the suit's memory begins."""
        self._states = dict(self._starts)

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the predicted resistance, divided by the peak torque and clipped to [-1, 1]."""
        torque = np.zeros(len(ASSISTED))
        for i, model in self._models.items():
            measured = float(observation[self._measured[i]])
            change = float(observation[self._target[i]]) - float(
                info["target_angle"][self._columns[i]]
            )
            self._states[i], _ = model.step(self._states[i], measured)
            _, torque[i] = model.step(self._states[i], measured + change)
        return np.clip(torque / self._peak, -1, 1)
