"""A readable reference of the Bouc-Wen model, and examples of the model."""

import math

from ...arrays import Array
from ..bouc_wen.model import BoucWen
from .reference import Example, Reference, refers_to, runge_kutta

ANGLE_STEP = 1e-3  # rad, longest Runge-Kutta step


@refers_to(BoucWen)
class BoucWenReference(Reference):
    """The differential equation of z as printed in `BoucWen`, by classical Runge-Kutta steps."""

    def __init__(self, model: BoucWen, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        self.z = self.z_of(self.angle, self.torque)

    def z_of(self, angle: float, torque: float) -> float:
        """Returns z [rad], computed from the torque."""
        elastic = self.model.elastic * (angle - self.model.rest_angle)
        return (torque - elastic) / self.model.hysteretic

    def equation(self, _: float, z: float, delta: float) -> float:
        """Returns dz/dtheta of a motion with the sign `delta`."""
        m = self.model
        return m.A - delta * m.beta * abs(z) ** (m.n - 1) * z - m.gamma * abs(z) ** m.n

    def step(self, z: float, h: float) -> float:
        """Returns z after a small motion h; steps across the kink at z = 0 are halved."""
        after = runge_kutta(self.equation, 0.0, z, h)
        if z * after < 0 and abs(h) > 1e-9:
            return self.step(self.step(z, h / 2), h / 2)
        return after

    def _torque_after(self, angle: float) -> float:
        steps = math.ceil(abs(angle - self.angle) / ANGLE_STEP)
        for _ in range(steps):
            self.z = self.step(self.z, (angle - self.angle) / steps)
        return self.model.elastic * (angle - self.model.rest_angle) + self.model.hysteretic * self.z

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        dz = self.equation(angle, self.z_of(angle, torque), delta)
        return self.model.elastic + self.model.hysteretic * dz

    def knots(self, end: float) -> list[float]:
        """Returns the angle [rad] at which z is zero."""
        angle, z, h = self.angle, self.z, math.copysign(ANGLE_STEP, end - self.angle)
        while z * h < 0 < (end - angle) * h and abs(h) > 1e-12:
            after = runge_kutta(self.equation, 0.0, z, h)
            if z * after < 0:
                h /= 2
            else:
                angle, z = angle + h, after
        return [angle]


_YIELDS = {"elastic": 3.0, "hysteretic": 9.0, "beta": 4.0, "rest_angle": 0.1}
EXAMPLES = (
    Example(name="bouc-wen, n = 1", model=BoucWen(**_YIELDS, gamma=1, n=1), low=-1, high=1),
    Example(name="bouc-wen, n = 1.7", model=BoucWen(**_YIELDS, gamma=-1, n=1.7), low=-1, high=1),
)
