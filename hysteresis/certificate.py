"""`Certificate`: guarantees that are proved before a model enters a simulation, and its errors."""

import math
from dataclasses import dataclass

from ..errors import InputError

ALL_ANGLES = (-math.inf, math.inf)
ROUNDING = 1e-9  # a margin must exceed this, since steps are computed in floating point


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Guarantees that hold for every motion in a range, however the angle turns back and forth.

    Attributes:
        margin: Number that is above rounding, 1e-9, if the stiffness dM/dtheta stays finite in
            every motion. For Jiles-Atherton the margin is the distance to the pole,
            1 - max(alpha f) over all reachable states; in a range with an unsafe state, over the
            states up to that state. For a model without a pole the margin is 1.
        dissipative: Whether no closed cycle of motion extracts energy from the model.
        torque_bound: Largest |M| in any such motion [N·m]; infinite if an elastic part grows
            without bound in the range.
        memory_bound: Largest allowed difference between the torque at the start and the torque to
            which the memory relaxes [N·m].
        angle_range: Angles for which these guarantees hold [rad].
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
        margin: Margin of the model's certificate.
        nearest: Certified model with the least change of curve, or None where none is known.
    """

    def __init__(self, message: str, *, margin: float, nearest: object = None) -> None:
        super().__init__(message)
        self.margin, self.nearest = margin, nearest


class PoleError(InputError):
    """A motion met the pole, where dM/dtheta is infinite and beyond which there is no torque."""


def checked_range(angle_range: tuple[float, float]) -> tuple[float, float]:
    """Returns a range as two ascending angles [rad], which may be infinite."""
    try:
        low, high = map(float, angle_range)
    except (TypeError, ValueError):
        low = high = math.nan
    if not low < high:
        raise InputError(f"angle_range is {angle_range!r}: give two ascending angles (rad)")
    return low, high
