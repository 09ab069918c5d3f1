"""What can be proved about a hysteresis model before it enters a simulation."""

import math
from dataclasses import dataclass

from ..errors import InputError

ALL_ANGLES = (-math.inf, math.inf)
ROUNDING = 1e-9  # what a margin must exceed, since steps are computed in floating point


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Guarantees that hold for every motion in a range, however the angle turns back and forth.

    Attributes:
        margin: the stiffness dM/dtheta stays finite for any motion when it is positive (above
            rounding, 1e-9). For Jiles-Atherton the distance to the pole, 1 - max(alpha f) over all
            reachable states, or, in a range where it is not positive, over those up to the first
            unsafe one; 1 for a model that has no pole.
        dissipative: no closed cycle of motion gets energy out of the model.
        torque_bound: largest |M| [N·m] in any such motion; infinite if an elastic part grows
            without bound in the range.
        memory_bound: largest distance [N·m] that the torque of a start may have from the one that
            the memory relaxes to.
        angle_range: the angles [rad] for which all this holds.
    """

    margin: float
    dissipative: bool
    torque_bound: float
    memory_bound: float = math.inf
    angle_range: tuple[float, float] = ALL_ANGLES

    @property
    def certified(self) -> bool:
        """Whether no motion that starts inside the memory bound can meet a pole."""
        return self.margin > ROUNDING


class UncertifiedModelError(InputError):
    """A model without a certificate was about to enter a simulation.

    Attributes:
        margin: the certificate's margin.
        nearest: the certified model with the least change of curve, where one is known.
    """

    def __init__(self, message: str, *, margin: float, nearest: object = None) -> None:
        super().__init__(message)
        self.margin, self.nearest = margin, nearest


class PoleError(InputError):
    """A motion met the pole, where dM/dtheta is infinite: the model has no torque beyond it."""


def checked_range(angle_range: tuple[float, float]) -> tuple[float, float]:
    """Returns two ascending angles [rad], infinite ones allowed.

    Raises:
        InputError: they are not.
    """
    try:
        low, high = map(float, angle_range)
    except (TypeError, ValueError):
        low = high = math.nan
    if not low < high:
        raise InputError(f"angle_range is {angle_range!r}: give two ascending angles (rad)")
    return low, high
