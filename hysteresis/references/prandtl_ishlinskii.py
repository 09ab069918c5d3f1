"""A readable reference of the Prandtl-Ishlinskii model, and examples of the model."""

import math

from ...arrays import Array
from ..prandtl_ishlinskii.model import PrandtlIshlinskii
from .reference import Example, Reference, refers_to


@refers_to(PrandtlIshlinskii)
class PrandtlIshlinskiiReference(Reference):
    """A list of stops, all zero at the start; a play is u = angle - rest_angle less its stop."""

    def __init__(self, model: PrandtlIshlinskii, angles: Array, _: float) -> None:
        self.model = model
        self.stops = [0.0 for _ in model.thresholds]
        super().__init__(angles[0], self.sum(angles[0]))

    def sum(self, angle: float) -> float:
        """Returns the torque [N·m] at `angle` with the stops as they are."""
        u = angle - self.model.rest_angle
        parts = [stop if self.model.operator == "stop" else u - stop for stop in self.stops]
        pairs = zip(self.model.weights, parts, strict=True)
        return self.model.stiffness * u + sum(weight * part for weight, part in pairs)

    def _torque_after(self, angle: float) -> float:
        pairs = zip(self.stops, self.model.thresholds, strict=True)
        self.stops = [min(max(stop + angle - self.angle, -r), r) for stop, r in pairs]
        return self.sum(angle)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        moved, total = abs(angle - self.angle), self.model.stiffness
        parts = zip(self.model.weights, self.model.thresholds, self.stops, strict=True)
        for weight, r, stop in parts:
            slips = delta * stop + moved >= r
            total += weight if slips == (self.model.operator == "play") else 0.0
        return total

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] at which a stop begins to slip."""
        delta = math.copysign(1.0, end - self.angle)
        pairs = zip(self.stops, self.model.thresholds, strict=True)
        return [self.angle + delta * r - stop for stop, r in pairs]


_THRESHOLDS = (0.05, 0.2, 0.7)
_STOPS = PrandtlIshlinskii(stiffness=1.5, thresholds=_THRESHOLDS, weights=(6, 4, 2), rest_angle=0.2)
_PLAYS = PrandtlIshlinskii(
    stiffness=12, thresholds=_THRESHOLDS, weights=(-5, -3, -2), operator="play", rest_angle=0.2
)
_FROM_REST = -1.0 - 0.2  # rad: all stops are at zero at the start
EXAMPLES = (
    Example(
        name="prandtl-ishlinskii stops",
        model=_STOPS,
        low=-1,
        high=1,
        start_torque=_STOPS.stiffness * _FROM_REST,
    ),
    Example(
        name="prandtl-ishlinskii plays",
        model=_PLAYS,
        low=-1,
        high=1,
        start_torque=(_PLAYS.stiffness + sum(_PLAYS.weights)) * _FROM_REST,
    ),
)
