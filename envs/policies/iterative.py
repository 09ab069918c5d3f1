"""Iterative learning: what is missing in one cycle of the work is added in the next."""

from typing import ClassVar

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ...arrays import Array
from ...checks import within
from ..belief import LEAD, Belief
from ..plant import Plant
from .base import Seen
from .model_based import SHARE, Compensation

CUTOFF = 4.0  # [Hz], greatest frequency that is learned; noise and the motors' lag are beyond
LONGEST = 60.0  # s


class IterativeLearning(Compensation):
    """Compensates, and adds in each cycle of the work what the person still gave in the last ones.

    Law: u(k+1, phase) = Q[u(k, phase) + L e(k, phase + lead)], with the torque e that the person
    gives to the suit beside what the motors relieve the arm of, and a filter Q without delay,
    since the whole cycle is known. It contracts by 1 - L a cycle where the person yields to the
    motors. Tuning: L is half of what would be right at once; the lead is the motors' lag. Signals:
    `interaction`, and the time of a cycle, which the task tells; where there is none the policy is
    compensation. Source: Zhang, Cheah and Collins (the best of nine torque controllers).

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        gain: Share L of what is missing that is added, 0 to 1.
        period: Time of a cycle [s]; 0 is that of the task.
        delay: Age of the torque between person and suit [s], 0 to 0.5.
        lead: Time by which the motors answer late [s], 0 to 0.2.
        friction: Share of the motors' friction that is cancelled, 0 to 1.
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders", "interaction")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        gain: float = 0.5,
        period: float = 0.0,
        delay: float = 0.05,
        lead: float = LEAD,
        friction: float = SHARE,
    ) -> None:
        super().__init__(plant, belief, lead=lead, friction=friction)
        within("gain", gain, 0, 1)
        within("period", period, 0, LONGEST, " s")
        within("delay", delay, 0, 0.5, " s")
        arm = plant.believed(belief)
        self._own = arm.whole_weight() - arm.carried_weight()
        self._gain, self._late = gain, round(delay / self.dt)
        self._cycle = round((period or plant.period or 0.0) / self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins with nothing learned."""
        super().begin(seen)
        shape = (max(self._cycle, 1), len(seen["angle"]), len(self.peak))
        self._learned, self._missing = np.zeros(shape), np.zeros(shape)
        self._period = 0

    def torque(self, seen: Seen) -> Array:
        """Returns compensation and what has been learned for this phase [N·m], (n, 2)."""
        torque = super().torque(seen)
        if not self._cycle:
            return torque
        own = self._own(seen["angle"])  # the arm's weight, which the motors carry too
        given = seen["interaction_torque"][:, self.assisted] + own
        self._missing[(self._period - self._late) % self._cycle] = given
        if self._period and self._period % self._cycle == 0:
            self._learned = learned(self._learned, self._missing, self._gain, self._ahead, self.dt)
        torque += self._learned[self._period % self._cycle]
        self._period += 1
        return torque

    @property
    def _ahead(self) -> int:
        return round(self.lead / self.dt)


def learned(known: Array, missing: Array, gain: float, ahead: int, dt: float) -> Array:
    """Returns the torques of the next cycle.

    Args:
        known: Torques of this cycle [N·m], shape (periods, ...).
        missing: What was missing in it, the same shape.
        gain: Share of it that is added.
        ahead: Periods by which torques are given earlier than they are missing.
        dt: Control period [s].
    """
    width = 1 / (2 * np.pi * CUTOFF * dt)
    found = known + gain * np.roll(missing, -ahead, axis=0)
    return gaussian_filter1d(found, width, axis=0, mode="wrap")
