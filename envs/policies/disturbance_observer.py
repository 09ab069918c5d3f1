"""Disturbance observer: cancels what the believed arm does not explain."""

from ...arrays import Array
from ...checks import within
from ..belief import Belief
from ..plant import Plant
from .base import Seen
from .carried import Carried, person
from .compensation import Compensation
from .filters import SecondOrderLowPass

BANDWIDTH = 2.0  # [Hz], limit at which the loop's gain is 0.31 at most


class DisturbanceObserver(Compensation):
    """Cancels, beside compensation, what the believed arm and suit do not explain.

    Law: compensation + d, with d = Q (known torque - P^-1 q): the torques of motors and person less
    what believed suit, weight, friction and inertia need for the measured motion, through a
    critically damped low-pass Q of second order.
    Tuning rule: the person's torque is measured T = 0.05 s late, so the loop from motor to wearer
    and back has the gain |Q| |1 - exp(-jwT)|, which must stay below 1: 5 Hz and less. The default
    leaves a factor of 2.
    Signals needed: encoders and the interaction torque. Without it the wearer is a disturbance, and
    is rejected like one.
    Source: Ohnishi, Shibata and Murakami 1996, IEEE/ASME T-Mech 1; Chen et al. 2016, IEEE T-IE 63.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        bandwidth: Natural frequency of the filter Q [Hz], 0.1 to 5.
    """

    sensors = ("encoders", "interaction")

    def __init__(
        self, plant: Plant, belief: Belief | None = None, *, bandwidth: float = BANDWIDTH
    ) -> None:
        super().__init__(plant, belief)
        within("bandwidth", bandwidth, 0.1, 5, " Hz")
        self._carried = Carried(plant, belief)
        self._moving = SecondOrderLowPass(bandwidth, self.dt)
        self._known = SecondOrderLowPass(bandwidth, self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins the filters at rest, as if nothing were unexplained."""
        super().begin(seen)
        momentum, known = self._carried(seen)
        self._moving.begin(momentum)
        self._known.begin(0 * known)

    def torque(self, seen: Seen) -> Array:
        """Returns compensation and the estimated disturbance [N·m], shape (n, 2)."""
        self._resistance = 0.0
        compensation = super().torque(seen)
        momentum, known = self._carried(seen)
        _, needed = self._moving.step(momentum)
        explained, _ = self._known.step(known + person(seen) - self._resistance)
        return compensation + explained - needed

    def suit_torque(self, seen: Seen) -> Array:
        """Keeps the believed resistance of the suit for the observer; returns it."""
        self._resistance = super().suit_torque(seen)
        return self._resistance
