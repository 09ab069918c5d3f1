"""What the agent sees: which numbers, in which order, between which limits."""

import math

import mujoco
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from ..assets import JOINTS
from ..errors import InputError
from .composition import ASSISTED
from .reference import Reference
from .wiring import Wiring

PREVIEW = (0.02, 0.1, 0.24)  # s ahead of now at which the target is shown, nearest first
MODES = ("sensors", "oracle")

# Part -> (size, limit of the observation space). Angles rad, rates rad/s, suit torque N·m.
PARTS = {
    "angle": (len(JOINTS), math.pi),
    "rate": (len(JOINTS), 20.0),
    "motor_torque": (len(ASSISTED), 1.0),
    "target": (len(PREVIEW) * len(ASSISTED), math.pi),
    "previous_action": (len(ASSISTED), 1.0),
}
ORACLE_PARTS = {"suit_torque": (len(JOINTS), 100.0)}


class Observer:
    """Assembles observations.

    Args:
        wiring: where the model keeps things.
        control_dt: time between observations [s], which must divide 0.02 s.
        mode: "sensors" or "oracle".

    Attributes:
        layout: which part of the observation is what.
        space: the observation space.
    """

    def __init__(self, wiring: Wiring, control_dt: float, mode: str) -> None:
        if mode not in MODES:
            raise InputError(f"observe is {mode!r}: use 'sensors' or 'oracle'")
        steps = PREVIEW[0] / control_dt
        if abs(steps - round(steps)) > 1e-9:
            raise InputError(f"control_dt is {control_dt}: it must divide {PREVIEW[0]} s")
        self._wiring, self._oracle = wiring, mode == "oracle"
        self._ahead = np.array([round(ahead / control_dt) for ahead in PREVIEW])
        parts = {**PARTS, **(ORACLE_PARTS if self._oracle else {})}
        ends = np.cumsum([size for size, _ in parts.values()]).tolist()
        self.layout = {
            name: slice(end - size, end)
            for (name, (size, _)), end in zip(parts.items(), ends, strict=True)
        }
        self._limit = np.concatenate([np.full(size, limit) for size, limit in parts.values()])
        limit = self._limit.astype(np.float32)
        self.space = Box(-limit, limit, dtype=np.float32)

    def __call__(
        self,
        data: mujoco.MjData,
        reference: Reference,
        step: int,
        previous_action: NDArray[np.float64],
    ) -> NDArray[np.float32]:
        """Returns a fresh observation of the present, clipped to its limits."""
        wiring = self._wiring
        shown = np.minimum(step + self._ahead, len(reference.angle) - 1)
        parts = [
            data.qpos[wiring.joints],
            data.qvel[wiring.joints],
            data.actuator_force[wiring.assist] / wiring.peak_torque,
            reference.angle[shown][:, wiring.assisted].ravel(),
            previous_action,
        ]
        if self._oracle:
            parts.append(wiring.suit_torque_of(data))
        observation = np.minimum(np.concatenate(parts), self._limit)
        return np.maximum(observation, -self._limit).astype(np.float32)
