"""The Bouc-Wen model of a joint's resistant torque."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import ClassVar

from ...arrays import Array
from ...checks import scales
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..protocol import ConfigKey, HysteresisModel, read_only
from . import kernels


@dataclass(frozen=True, kw_only=True)
class BoucWen(HysteresisModel):
    """A spring in parallel with a spring that yields smoothly (Bouc 1967, Wen 1976).

        T  = elastic (theta - rest_angle) + hysteretic z
        dz = A dtheta - beta |dtheta| |z|^(n-1) z - gamma dtheta |z|^n,    z in radians

    beta opens the loop, gamma bends the loop (softening above -beta, hardening below), n sharpens
    the yield. The scale of z is redundant: every torque has parameters with A = 1.

    The joint stores elastic (theta - rest_angle)^2 / 2 + hysteretic z^2 / (2 A), and dissipates

        hysteretic / A (beta + gamma sign(z dtheta)) |z|^(n+1) |dtheta|.

    Attributes:
        elastic: Stiffness after yield [N·m/rad].
        hysteretic: Torque per z, not 0 [N·m/rad].
        A: Slope dz/dtheta at z = 0, > 0.
        beta: Loss coefficient, which opens the loop [1/rad^n].
        gamma: Shape coefficient, which bends the loop [1/rad^n].
        n: Sharpness of the yield, 1 to 1e6.
        rest_angle: Angle at which the elastic part is zero [rad].
    """

    name: ClassVar[str] = "bouc-wen"
    kernels: ClassVar[ModuleType] = kernels
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (
        *map(ConfigKey, ("elastic", "hysteretic", "A", "beta", "gamma", "n")),
        ConfigKey("rest_angle", optional=True),
    )
    not_fitted: ClassVar[tuple[str, ...]] = ("A",)
    least: ClassVar[Mapping[str, float]] = {"hysteretic": 0.0, "beta": 0.0, "n": 1.0}
    units: ClassVar[Mapping[str, str]] = {
        "elastic": "N·m/rad",
        "hysteretic": "N·m/rad",
        "beta": "1/rad^n",
        "gamma": "1/rad^n",
        "rest_angle": "rad",
    }

    elastic: float
    hysteretic: float
    beta: float
    gamma: float
    n: float
    A: float = 1.0
    rest_angle: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.hysteretic == 0:
            raise self._wrong("hysteretic", "give a number other than 0")
        if self.A <= 0:
            raise self._wrong("A", "give a number above 0")
        if not 1 <= self.n <= kernels.LARGEST_POWER:
            raise self._wrong("n", "give a number from 1 to 1e6")

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters as the kernels read them, with the scale and sign of both branches."""
        branches: list[float] = []
        for curvature in (self.beta + self.gamma, self.gamma - self.beta):
            ratio = self.A / abs(curvature) if curvature else math.inf
            # A curvature too small for a finite ratio counts as 0.
            sign = math.copysign(1.0, curvature) if ratio < math.inf else 0.0
            branches += [ratio ** (1 / self.n) if sign else 1.0, sign]
        own = self.elastic, self.hysteretic, self.rest_angle, self.A, self.n
        return read_only([*own, *branches])

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's; z stays, within `z_bound`."""
        largest = float(kernels.bound(self._parameters))
        z = min(max(float(memory[kernels.Z]), -largest), largest)
        elastic = self.elastic * (float(memory[kernels.ANGLE]) - self.rest_angle)
        return self._at_torque(elastic + self.hysteretic * z, memory, parameters)

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> "BoucWen":
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta."""
        scales(torque=torque, angle=angle)
        shape = angle**-self.n
        return replace(
            self,
            elastic=self.elastic * torque / angle,
            hysteretic=self.hysteretic * torque / angle,
            beta=self.beta * shape,
            gamma=self.gamma * shape,
            rest_angle=self.rest_angle * angle,
        )

    @property
    def z_bound(self) -> float:
        """Limit of |z| [rad] for every motion that starts within; infinite for no limit."""
        return float(kernels.bound(self._parameters))

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Proves that z has no pole, and that the joint only takes energy.

        With y = z sign(dtheta) and per angle moved, y' = A - (beta + gamma) y^n while y > 0 and
        m' = -(A + (beta - gamma) m^n) while m = -y > 0. For n = 1 both are linear: z is finite at
        any angle. For n > 1 z is finite too if beta >= 0 and beta + gamma >= 0:

        - beta + gamma > 0: loading stops short of y_s = (A / (beta + gamma))^(1/n), and unloading
          from m <= y_s never raises m, since there A + (beta - gamma) m^n is at least the smaller
          of A and A + (beta - gamma) y_s^n = 2 beta y_s^n. So |z| <= y_s for ever.
        - beta + gamma = 0: y' = A and m' = -(A + 2 beta m^n) <= -A.

        With beta + gamma < 0 loading has a pole, and with beta < 0 unloading from near y_s has one.
        The margin is then the smaller of beta and beta + gamma, over |beta| + |gamma|.

        The rate of dissipation (see the class) is never negative exactly if hysteretic beta >=
        |hysteretic gamma|, the thermodynamic condition of Erlicher and Point (2004).
        """
        low, high = angle_range = checked_range(angle_range)
        size = abs(self.beta) + abs(self.gamma)
        weakest = min(self.beta, self.beta + self.gamma)
        memory_bound = abs(self.hysteretic) * self.z_bound
        reach = max(abs(low - self.rest_angle), abs(high - self.rest_angle))
        elastic_bound = abs(self.elastic) * reach if self.elastic else 0.0
        return Certificate(
            margin=1.0 if self.n == 1 or weakest >= 0 else weakest / size,
            dissipative=self.hysteretic * self.beta >= abs(self.hysteretic * self.gamma),
            torque_bound=elastic_bound + memory_bound,
            memory_bound=memory_bound,
            angle_range=angle_range,
        )
