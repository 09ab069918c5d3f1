"""Momentum observer: the suit's torque is what the known torques do not explain."""

import math

import numpy as np

from ...arrays import Array
from ...checks import within
from ..belief import LEAD, Belief
from ..plant import Plant
from .base import Seen
from .carried import Carried, person
from .model_based import SHARE, ModelBased

BANDWIDTH = 10.0  # rad/s, half of the inverse of 0.05 s, the age of the interaction torque


class MomentumObserver:
    """Estimates the torque that changes a momentum beside the torques that are known.

    The residual r = K (p - integral of (known + r)) needs no acceleration. It follows the unknown
    torque as a low-pass of first order with the bandwidth K.
    Source: De Luca and Mattone 2003, ICRA; Haddadin, De Luca and Albu-Schäffer 2017, IEEE T-RO 33.

    Args:
        bandwidth: Bandwidth K [rad/s].
        dt: Period [s].
    """

    def __init__(self, bandwidth: float, dt: float) -> None:
        self._gain, self._dt = (1 - math.exp(-bandwidth * dt)) / dt, dt  # exact if torques stay

    def begin(self, momentum: Array) -> None:
        """Begins with the residual zero, at a momentum [N·m·s], any shape."""
        self._explained, self._residual = momentum.copy(), np.zeros_like(momentum)

    def step(self, momentum: Array, known: Array) -> Array:
        """Returns the residual after a period [N·m], the same shape.

        Args:
            momentum: Momentum at the end of the period [N·m·s].
            known: Known torque during the period, with C'q' - g [N·m].
        """
        self._explained = self._explained + (known + self._residual) * self._dt
        self._residual = self._gain * (momentum - self._explained)
        return self._residual


class ObserverAssist(ModelBased):
    """Cancels the suit's torque that a momentum observer finds, without any model of the suit.

    Law: believed weight and friction, less the residual of a momentum observer of all that the bare
    arm carries. The observer knows motors, weight, friction and the person's torque.
    Tuning rule: the person's torque is measured 0.05 s late, so the loop from motor to wearer and
    back has a gain of at most K times 0.05 s, which the default makes one half.
    Signals needed: encoders and the interaction torque. Without a measurement of the person the
    residual contains the person's torque as well, and a policy that cancels it fights the
    wearer: relief is then that of motors that are off.
    Source: De Luca and Mattone 2003 (see `MomentumObserver`).

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of masses; it needs no suit.
        bandwidth: Bandwidth K of the observer [rad/s], 0.1 to 20.
        lead: Time by which the motors answer late [s], 0 to 0.2.
    """

    sensors = ("encoders", "interaction")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        bandwidth: float = BANDWIDTH,
        lead: float = LEAD,
    ) -> None:
        weight = plant.believed(belief).whole_weight()
        super().__init__(plant, weight=weight, friction=SHARE, lead=lead)
        within("bandwidth", bandwidth, 0.1, 20, " rad/s")
        self._carried = Carried(plant, belief)
        self._observer = MomentumObserver(bandwidth, self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins the observer with nothing unexplained."""
        super().begin(seen)
        self._observer.begin(self._carried(seen)[0])

    def torque(self, seen: Seen) -> Array:
        """Returns weight, friction and the suit's estimated torque [N·m], shape (n, 2)."""
        momentum, known = self._carried(seen)
        return super().torque(seen) - self._observer.step(momentum, known + person(seen))
