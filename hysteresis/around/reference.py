"""Readable references of `Asymmetric` and `Held`, and examples of all models around another."""

import numpy as np

from ...arrays import Array
from ..jiles_atherton import TABLE_2
from ..reference import Example, Reference
from .asymmetric import Asymmetric
from .held import Held
from .viscoelastic import Viscoelastic


class AsymmetricReference(Reference):
    """The reference of the inner model, plus the polynomial."""

    def __init__(self, model: Asymmetric, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.coefficients = [float(p) for p in model.polynomial]
        self.inner = model.model.reference(angles, torque - self.polynomial(self.angle))

    def polynomial(self, angle: float) -> float:
        """Returns the elastic torque [N·m]."""
        return sum(p * angle**i for i, p in enumerate(self.coefficients))

    def _torque_after(self, angle: float) -> float:
        return self.inner.move(angle) + self.polynomial(angle)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        bend = sum(i * p * angle ** (i - 1) for i, p in enumerate(self.coefficients) if i)
        return self.inner.slope(angle, torque - self.polynomial(angle), delta) + bend

    def knots(self, end: float) -> list[float]:
        """Returns the knots of the inner reference [rad]; the polynomial is smooth."""
        return self.inner.knots(end)


class HeldReference(Reference):
    """The reference of the inner model, moved to angles inside the range only."""

    def __init__(self, model: Held, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.range = model.angle_range
        self.inner = model.model.reference(np.clip(angles, *self.range), torque)

    def _torque_after(self, angle: float) -> float:
        return self.inner.move(float(np.clip(angle, *self.range)))

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        inside = self.range[0] < angle < self.range[1]
        return self.inner.slope(angle, torque, delta) if inside else 0.0

    def knots(self, end: float) -> list[float]:
        """Returns the ends of the range and the knots of the inner reference [rad]."""
        return [*self.range, *self.inner.knots(end)]


_ELBOW = TABLE_2["elbow-sa-pso"]
HELD_EXAMPLES = (
    Example(
        name="held, elbow-sa-pso",
        model=Held(model=_ELBOW, angle_range=(0.7, 1.3)),
        low=0.52,
        high=1.57,
    ),
)
ASYMMETRIC_EXAMPLES = (
    Example(
        name="asymmetric, elbow-sa-pso",
        model=Asymmetric(model=_ELBOW, polynomial=[0.3, -0.5, 0.8]),
        low=0.52,
        high=1.57,
    ),
)
VISCOELASTIC_EXAMPLES = (
    Example(
        name="viscoelastic, elbow-sa-pso",
        model=Viscoelastic(model=_ELBOW, damping=0.2),
        low=0.52,
        high=1.57,
    ),
)
