"""Force amplification: the motors add to what the person gives to the suit."""

import math

from activesuit.arrays import Array
from activesuit.checks import within
from activesuit.envs.plant import Plant
from activesuit.envs.policies import Seen, Transparent
from scipy.optimize import root_scalar

CUTOFF = 1.0  # [Hz], faster than most of the wearer's motion
LATE = 0.08  # s: age of the interaction torque, 0.05, the motors' lag, 0.016, and a period
AMPLIFICATION = 2.0  # a gain of 1 around the loop, which is stable at any delay


class ForceAmplification(Transparent):
    """Multiplies the torque that the person gives to the suit, beside transparency.

    Law: transparent + (alpha - 1) times the interaction torque, through a low-pass of first order.
    Tuning rule: the motors' torque comes back as less interaction after a delay T, so alpha - 1 is
    the loop's gain. At most 1 is stable at any delay; more only up to half of the gain at which
    low-pass and delay turn the phase around (`greatest_amplification`), 2.9 by default.
    Signals needed: encoders and the interaction torque.
    Source: Kazerooni 1990, Human-robot interaction via the transfer of power and information
    signals, IEEE T-SMC 20.

    Args:
        plant: What the policy may know of the arms.
        alpha: Amplification, from 1, which adds nothing, to `greatest_amplification`.
        cutoff: Cutoff of the low-pass [Hz], 0.1 to 5.
    """

    sensors = ("encoders", "interaction")

    def __init__(
        self, plant: Plant, *, alpha: float = AMPLIFICATION, cutoff: float = CUTOFF
    ) -> None:
        super().__init__(plant)
        within("cutoff", cutoff, 0.1, 5, " Hz")
        within("alpha", alpha, 1, greatest_amplification(cutoff))
        self._gain, self._share = alpha - 1, -math.expm1(-math.tau * cutoff * self.dt)

    def begin(self, seen: Seen) -> None:
        """Begins the low-pass at the first torque."""
        super().begin(seen)
        self._person = seen["interaction_torque"][:, self.assisted]

    def torque(self, seen: Seen) -> Array:
        """Returns transparency and the amplified torque of the person [N·m], shape (n, 2)."""
        measured = seen["interaction_torque"][:, self.assisted]
        self._person = self._person + self._share * (measured - self._person)
        return super().torque(seen) + self._gain * self._person


def greatest_amplification(cutoff: float) -> float:
    """Returns the amplification of half the critical gain of a low-pass and the loop's delay.

    Args:
        cutoff: Cutoff of the low-pass [Hz].
    """

    def beyond(speed: float) -> float:
        """Returns the phase lag of low-pass and delay beyond half a turn [rad]."""
        return math.atan(speed / (math.tau * cutoff)) + speed * LATE - math.pi

    speed = float(root_scalar(beyond, bracket=(0.0, math.pi / LATE)).root)
    return 1 + max(1.0, math.hypot(1, speed / (math.tau * cutoff)) / 2)
