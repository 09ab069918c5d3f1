"""What can be proved about a hysteresis model before it enters a simulation."""

from dataclasses import dataclass

from ..errors import InputError


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Guarantees that hold for every motion, however the angle turns back and forth.

    Attributes:
        margin: distance to the pole, 1 - max(alpha f) over all reachable states; the stiffness
            dM/dH stays finite for any motion when it is positive.
        dissipative: no closed cycle of motion gets energy out of the model.
        memory_bound: largest |M - Man| [N·m] of the states the certificate speaks of; a motion
            that starts inside stays inside.
        torque_bound: largest |M| [N·m] in any such motion.
    """

    margin: float
    dissipative: bool
    memory_bound: float
    torque_bound: float

    @property
    def certified(self) -> bool:
        """Whether no motion that starts inside the memory bound can meet the pole."""
        return self.margin > 0


class UncertifiedModelError(InputError):
    """A model without a certificate was about to enter a simulation."""


class PoleError(InputError):
    """A motion met the pole, where dM/dH is infinite: the model has no torque beyond it."""
