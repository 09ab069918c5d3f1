"""Hysteresis feed-forward: the motors cancel the suit torque that an identified model predicts."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...assets import SuitJoint
from ...errors import InputError
from ..belief import BelievedSuit, count_of
from ..model import ASSISTED
from .base import Arms


class HysteresisFeedforward:
    """Commands the suit torque that a model predicts, which keeps its own memory of the motion.

    See `BelievedSuit` for the law.

    Args:
        env: Environment in which the policy acts, single or vector.
        joints: Joints of the suit that the controller believes in, which need not be the simulated
            suit; a joint that is missing gets no assist.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, env: Arms, joints: Mapping[str, SuitJoint]) -> None:
        episodes = env.episodes
        addresses, layout = episodes.simulation.addresses, episodes.observer.layout
        bits = episodes.simulation.config.exo.encoder_bits
        self._suit = BelievedSuit(joints, count_of(bits))
        self._angle = layout["angle"].start + addresses.assisted
        self._rate = layout["rate"].start + addresses.assisted
        self._peak = addresses.peak_torque
        self.reset()

    def reset(self) -> None:
        """Resets the memory to the state in which the suit's memory begins."""
        self._memory: NDArray[np.float64] | None = None

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the predicted resistance, divided by the peak torque and clipped to [-1, 1]."""
        angle = observation[..., self._angle].reshape(-1, len(ASSISTED)).astype(np.float64)
        rate = observation[..., self._rate].reshape(-1, len(ASSISTED)).astype(np.float64)
        if self._memory is None:
            self._memory = self._suit.begin(angle)
        elif len(self._memory) != len(angle):
            raise InputError(
                f"the policy sees {len(angle)} arms, and {len(self._memory)} since its reset: "
                "reset it, or make one for each environment"
            )
        torque = self._suit.follow(self._memory, angle, rate)
        share = np.clip(torque / self._peak, -1, 1)
        return share.reshape(*observation.shape[:-1], len(ASSISTED))
