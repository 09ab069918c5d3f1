"""A readable reference of hinged stops, and examples of the model."""

import copy

import numpy as np

from ...arrays import Array
from ..hinged_stops.model import HingedStops
from .prandtl_ishlinskii import PrandtlIshlinskiiReference
from .reference import Example, Reference, refers_to


@refers_to(HingedStops)
class HingedStopsReference(Reference):
    """The readable Prandtl-Ishlinskii model, and a sum of hinges over its torque P."""

    def __init__(self, model: HingedStops, angles: Array, _: float) -> None:
        self.model = model
        self.stops = PrandtlIshlinskiiReference(model.stops, angles, 0.0)
        super().__init__(angles[0], self.hinge(self.stops.torque))

    def hinge(self, P: float) -> float:
        """Returns the torque offset + h(P): a line, and a change of slope at each knot."""
        total = self.model.offset + self.model.slopes[0] * P
        for knot, change in zip(self.model.knots, np.diff(self.model.slopes), strict=True):
            total += change * (max(P - knot, 0.0) - max(-knot, 0.0))
        return total

    def ahead(self, angle: float) -> float:
        """Returns P [N·m] at a later angle of the present branch."""
        return copy.copy(self.stops).move(angle)

    def _torque_after(self, angle: float) -> float:
        return self.hinge(self.stops.move(angle))

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        piece = int(np.searchsorted(self.model.knots, self.ahead(angle)))
        return self.stops.slope(angle, torque, delta) * self.model.slopes[piece]

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] at which a stop begins to slip, or P passes a knot."""
        low, high = sorted((self.angle, end))
        slips = [x for x in self.stops.knots(end) if low < x < high]
        angles = np.array(sorted({low, *slips, high}))
        P = np.array([self.ahead(x) for x in angles])  # linear in between
        inside = [knot for knot in self.model.knots if P[0] < knot < P[-1]]
        return [*slips, *np.interp(inside, P, angles).tolist()]


EXAMPLES = (
    Example(
        name="hinged stops",
        model=HingedStops(
            stiffness=1.5,
            thresholds=(0.05, 0.2, 0.7),
            weights=(6, 4, 2),
            knots=(-1.5, 0.5, 2),
            slopes=(0.4, 1, 0.3, 1.6),
            offset=0.2,
            rest_angle=0.2,
        ),
        low=-1,
        high=1,
        start_torque=0.2 - 0.4 * 0.3 - 1.5,
    ),
)
