"""A readable reference of the Jiles-Atherton model, and examples of the model."""

import math

from ...arrays import Array
from ...published import LI_RANGES
from ..jiles_atherton.model import JilesAtherton
from ..jiles_atherton.table_2 import TABLE_2
from .reference import Example, Reference, refers_to, runge_kutta

FIELD_STEP = 0.05  # degrees, longest Runge-Kutta step


@refers_to(JilesAtherton)
class JilesAthertonReference(Reference):
    """Eq. (4) of Li et al. 2022 as printed, by classical Runge-Kutta steps in H."""

    def __init__(self, model: JilesAtherton, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        self.unit = 180 / math.pi if model.angle_unit == "deg" else 1.0

    def equation(self, H: float, M: float, delta: float) -> float:
        """Returns dM/dH in the unit of the parameters."""
        Ms, a, alpha, c, k = (getattr(self.model, name) for name in ("Ms", "a", "alpha", "c", "k"))
        L, dL = langevin((H + alpha * M) / a)
        numerator = Ms * L - M + c * delta * k * Ms / a * dL
        return numerator / (delta * k - alpha * numerator)

    def _torque_after(self, angle: float) -> float:
        H, end = self.angle * self.unit, angle * self.unit
        steps = math.ceil(abs(angle - self.angle) * 180 / math.pi / FIELD_STEP)
        h, M = (end - H) / steps, self.torque
        for i in range(steps):
            M = runge_kutta(self.equation, H + i * h, M, h)
        return M

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
        return self.equation(angle * self.unit, torque, delta) * self.unit


def langevin(x: float) -> tuple[float, float]:
    """Returns L(x) = coth x - 1/x and L'(x); the series near 0, where the closed forms cancel."""
    if abs(x) < 0.05:
        L = x / 3 - x**3 / 45 + 2 * x**5 / 945 - x**7 / 4725
        return L, 1 / 3 - x**2 / 15 + 2 * x**4 / 189 - x**6 / 675
    return 1 / math.tanh(x) - 1 / x, 1 / x**2 - 1 / math.sinh(x) ** 2


EXAMPLES = tuple(
    Example(name=f"J-A {name}", model=model, low=low, high=high)
    for name, model in TABLE_2.items()
    for low, high in [LI_RANGES[name.partition("-")[0]]]
)
