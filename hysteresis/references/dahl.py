"""A readable reference of Dahl's friction and the Duhem model, and examples of both."""

import math

from ...arrays import Array
from ..dahl.model import Dahl, Duhem
from .reference import Example, Reference, refers_to, runge_kutta

ANGLE_STEP = 1e-3  # rad, longest Runge-Kutta step


@refers_to(Dahl)
@refers_to(Duhem)
class DuhemReference(Reference):
    """The differential equation of z as printed in `Duhem`, by classical Runge-Kutta steps."""

    def __init__(self, model: Dahl | Duhem, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        equal = isinstance(model, Dahl)
        self.up = model.friction if equal else model.friction_up
        self.down = model.friction if equal else model.friction_down
        self.z = self.torque - self.elastic(self.angle)

    def elastic(self, angle: float) -> float:
        """Returns the torque of the spring [N·m]."""
        return sum(p * angle**i for i, p in enumerate(self.model.spring))

    def equation(self, _: float, z: float, delta: float) -> float:
        """Returns dz/dtheta [N·m/rad] of a motion with the sign `delta`."""
        return self.model.stiffness * (1 - z / self.up if delta > 0 else 1 + z / self.down)

    def _torque_after(self, angle: float) -> float:
        steps = math.ceil(abs(angle - self.angle) / ANGLE_STEP)
        for _ in range(steps):
            self.z = runge_kutta(self.equation, 0.0, self.z, (angle - self.angle) / steps)
        return self.elastic(angle) + self.z

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        bend = sum(i * p * angle ** (i - 1) for i, p in enumerate(self.model.spring) if i)
        return bend + self.equation(angle, torque - self.elastic(angle), delta)


_SPRING = (0.5, 3.0, -1.0, 0.8)
DAHL_EXAMPLES = (
    Example(
        name="dahl",
        model=Dahl(spring=_SPRING, stiffness=9.0, friction=1.5),
        low=-1,
        high=1,
        start_torque=-4.0,
    ),
)
DUHEM_EXAMPLES = (
    Example(
        name="duhem",
        model=Duhem(spring=_SPRING, stiffness=9.0, friction_up=1.5, friction_down=0.6),
        low=-1,
        high=1,
        start_torque=-4.5,
    ),
)
