"""Hysteresis feed-forward: the motors cancel the suit torque that an identified model predicts."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...assets import SuitJoint
from ...errors import InputError
from ...hysteresis.protocol import State
from ..model import ASSISTED
from ..provenance import Quantity
from .base import Arms

_LEAD = Quantity(
    "feedforward.lead",
    0.02,
    "s",
    "a motor's lag at 10 Hz, 0.016 s, and half a control period",
    "derived",
)
PROVENANCE: tuple[Quantity, ...] = (_LEAD,)


class HysteresisFeedforward:
    """Predicts the suit torque by a model that keeps its own memory of the motion.

    The memory follows the measured angle; a change of one encoder count is no motion. The command
    is the model's torque at the angle where the joint will be when the motors have answered: the
    measured angle plus 0.02 s of the measured rate. It needs nothing of what the wearer intends.

    Args:
        env: Environment in which the policy acts, single or vector.
        joints: Joints of the suit that the controller believes in, which need not be the simulated
            suit; a joint that is missing gets no assist.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, env: Arms, joints: Mapping[str, SuitJoint]) -> None:
        episodes = env.episodes
        addresses, layout = episodes.simulation.addresses, episodes.observer.layout
        entries = {i: joints[name] for i, name in enumerate(ASSISTED) if name in joints}
        self._models = {i: entry.model for i, entry in entries.items()}
        self._starts = {i: entry.begun() for i, entry in entries.items()}
        self._angle = layout["angle"].start + addresses.assisted
        self._rate = layout["rate"].start + addresses.assisted
        self._peak = addresses.peak_torque
        self._count = 1.5 * np.pi * 2 / 2**episodes.simulation.config.exo.encoder_bits
        self.reset()

    def reset(self) -> None:
        """Resets the memory to the state in which the suit's memory begins."""
        self._states: dict[int, list[State]] = {}
        self._followed: NDArray[np.float64] | None = None

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the predicted resistance, divided by the peak torque and clipped to [-1, 1]."""
        angle = observation[..., self._angle].reshape(-1, len(ASSISTED)).astype(np.float64)
        rate = observation[..., self._rate].reshape(-1, len(ASSISTED)).astype(np.float64)
        if self._followed is None:
            self._followed = angle.copy()
            self._states = {i: [start] * len(angle) for i, start in self._starts.items()}
        elif len(self._followed) != len(angle):
            raise InputError(
                f"the policy sees {len(angle)} arms, and {len(self._followed)} since its reset: "
                "reset it, or make one for each environment"
            )
        moved = np.abs(angle - self._followed) > self._count
        self._followed = np.where(moved, angle, self._followed)
        later = angle + _LEAD.value * rate
        torque = np.zeros_like(angle)
        for i, model in self._models.items():
            states = self._states[i]
            for row, followed in enumerate(self._followed[:, i].tolist()):
                states[row], _ = model.step(states[row], followed)
                _, torque[row, i] = model.step(states[row], float(later[row, i]))
        share = np.clip(torque / self._peak, -1, 1)
        return share.reshape(*observation.shape[:-1], len(ASSISTED))
