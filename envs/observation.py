"""The observation of the agent: its parts, their order and their limits."""

import math

import mujoco
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from ..assets import JOINTS
from ..errors import InputError
from .model import ASSISTED, quantize
from .reference import Reference
from .wiring import Wiring

PREVIEW = (0.02, 0.1, 0.24)  # s ahead of now at which the target is shown, nearest first
MODES = ("sensors", "oracle")


class Observer:
    """Assembles observations.

    Args:
        wiring: Addresses of the model.
        encoder_bits: Resolution of the encoders; a turn has 2**bits counts.
        control_dt: Time between observations [s], which must divide 0.02 s.
        mode: Content of the observation, "sensors" or "oracle".

    Attributes:
        layout: Slice of the observation that holds each part, by the name of the part.
        space: Observation space of Gymnasium.
    """

    def __init__(self, wiring: Wiring, encoder_bits: int, control_dt: float, mode: str) -> None:
        if mode not in MODES:
            raise InputError(f"observe is {mode!r}: use 'sensors' or 'oracle'")
        steps = PREVIEW[0] / control_dt
        if abs(steps - round(steps)) > 1e-9:
            raise InputError(f"control_dt is {control_dt}: it must divide {PREVIEW[0]} s")
        self._wiring, self._oracle = wiring, mode == "oracle"
        self._encoder_bits = encoder_bits
        self._ahead = np.array([round(ahead / control_dt) for ahead in PREVIEW])
        parts = _parts(wiring, self._oracle)
        ends = np.cumsum([size for size, _ in parts.values()]).tolist()
        self.layout = {
            name: slice(end - size, end)
            for (name, (size, _)), end in zip(parts.items(), ends, strict=True)
        }
        limit = np.concatenate([np.full(size, limit, np.float32) for size, limit in parts.values()])
        self.space = Box(-limit, limit, dtype=np.float32)

    def begin(self, reference: Reference) -> None:
        """Prepares the targets that are observed along an intention."""
        last = len(reference.angle) - 1
        shown = np.minimum(np.arange(last + 1)[:, None] + self._ahead, last)
        self._targets = reference.angle[shown][:, :, self._wiring.assisted].reshape(last + 1, -1)

    def __call__(
        self, data: mujoco.MjData, step: int, previous_action: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        """Returns a new observation of this instant, clipped to its limits.

        Args:
            data: Physics of this instant.
            step: The control period in the intention that `begin` was given, not beyond its last.
            previous_action: Previous action of the agent, one number per motor.
        """
        wiring = self._wiring
        parts = [
            quantize(data.sensordata[wiring.encoders], self._encoder_bits),
            data.sensordata[wiring.encoder_rates],
            data.actuator_force[wiring.assist] / wiring.peak_torque,
            self._targets[step],
            previous_action,
        ]
        if wiring.cuffs.size:
            parts.append(data.sensordata[wiring.cuffs].ravel())
        if self._oracle:
            parts.append(wiring.suit_torque_of(data))
        observation = np.concatenate(parts, dtype=np.float32, casting="same_kind")
        return np.maximum(np.minimum(observation, self.space.high), self.space.low)


def _parts(wiring: Wiring, oracle: bool) -> dict[str, tuple[int, float]]:
    """Returns size and limit of every part, in rad, rad/s, N (cuffs) and N·m (suit)."""
    motors = wiring.motors.size
    parts = {
        "angle": (len(JOINTS), math.pi),
        "rate": (len(JOINTS), 20.0),
        "motor_torque": (motors, 1.0),
        "target": (len(PREVIEW) * len(ASSISTED), math.pi),
        "previous_action": (motors, 1.0),
        "cuff_force": (wiring.cuffs.size, 1000.0),
        "suit_torque": (len(JOINTS) * oracle, 100.0),
    }
    return {name: part for name, part in parts.items() if part[0]}
