"""Dahl's friction and the semilinear Duhem model, each beside a polynomial spring."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import ClassVar

import numpy as np
from numpy.polynomial import polynomial as poly

from ...arrays import Array
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..polynomial import LARGEST_DEGREE, extremes
from ..protocol import POLYNOMIAL, ConfigKey, HysteresisModel, Numbers, read_only
from . import kernels

KEYS = (ConfigKey("spring", "list"), ConfigKey("stiffness"))
MOST_COEFFICIENTS = LARGEST_DEGREE + 1
UNITS = {"spring": POLYNOMIAL, "stiffness": "N·m/rad"}


@dataclass(frozen=True, kw_only=True)
class Semilinear(HysteresisModel):
    """The base of `Dahl` and `Duhem`."""

    kernels: ClassVar[ModuleType] = kernels

    spring: Numbers
    stiffness: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.spring) > MOST_COEFFICIENTS:
            raise self._wrong("spring", f"give 1 to {MOST_COEFFICIENTS} coefficients")
        for name in self.least:
            if getattr(self, name) <= 0:
                raise self._wrong(name, "give a number above 0")

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters as the kernels read them: stiffness, both frictions, the spring."""
        spring, stiffness, *frictions = HysteresisModel.config(self).values()
        return read_only([stiffness, frictions[0], frictions[-1], *spring])

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate, which holds for all parameters and every motion.

        Upwards z approaches friction_up and downwards -friction_down, so that z never leaves the
        range between these limits, and the stiffness is finite everywhere. The spring stores the
        integral of p, and the friction z^2 / (2 stiffness). The rest of the work z dtheta is
        z^2 / friction_up |dtheta| upwards and z^2 / friction_down |dtheta| downwards: the model
        dissipates, from any start. The memory bound is the smaller friction.
        """
        low, high = checked_range(angle_range)
        _, up, down = self.parameter_vector[: kernels.SPRING].tolist()
        least, largest = extremes(self.spring, low, high)
        return Certificate(
            margin=1.0,
            dissipative=True,
            torque_bound=max(largest + up, down - least),
            memory_bound=min(up, down),
            angle_range=(low, high),
        )

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's; the share of z in its limit stays."""
        z = float(memory[kernels.Z])
        limit = kernels.UP if z > 0 else kernels.DOWN
        z *= float(self.parameter_vector[limit]) / float(parameters[limit])
        spring = float(poly.polyval(memory[kernels.ANGLE], np.array(self.spring)))
        return self._at_torque(spring + z, memory, parameters)


@dataclass(frozen=True, kw_only=True)
class Dahl(Semilinear):
    """A polynomial spring beside Dahl's friction, with one number of memory.

        T = p(theta) + z,    dz = stiffness (1 - sign(dtheta) z / friction) dtheta

    (Dahl 1968, "A solid friction model", with the exponent 1.) With a straight spring this is a
    Bouc-Wen model of n = 1 and gamma = 0. The joint stores the integral of p and
    z^2 / (2 stiffness), and dissipates z^2 / friction |dtheta|.

    Attributes:
        spring: Coefficients of p, constant first, one to six [N·m/rad^i].
        stiffness: Slope dz/dtheta at z = 0, > 0 [N·m/rad].
        friction: Largest |z|, > 0 [N·m].
    """

    name: ClassVar[str] = "dahl"
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (*KEYS, ConfigKey("friction"))
    least: ClassVar[Mapping[str, float]] = {"stiffness": 0.0, "friction": 0.0}
    units: ClassVar[Mapping[str, str]] = {**UNITS, "friction": "N·m"}

    friction: float


@dataclass(frozen=True, kw_only=True)
class Duhem(Semilinear):
    """A polynomial spring beside a friction that differs between upwards and downwards.

        T  = p(theta) + z
        dz = stiffness (1 - z / friction_up) dtheta       upwards
        dz = stiffness (1 + z / friction_down) dtheta     downwards

    Every semilinear Duhem model (Macki, Nistri and Zecca 1993; Padthe, Oh and Bernstein 2008) that
    approaches a higher limit upwards than downwards, each at a rate of its own, is of this form,
    with a constant torque in p. With equal frictions the model is `Dahl`.

    Attributes:
        spring: Coefficients of p, constant first, one to six [N·m/rad^i].
        stiffness: Slope dz/dtheta at z = 0, the same on both ways, > 0 [N·m/rad].
        friction_up: Limit of z upwards, > 0 [N·m].
        friction_down: Limit of -z downwards, > 0 [N·m].
    """

    name: ClassVar[str] = "duhem"
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (
        *KEYS,
        ConfigKey("friction_up"),
        ConfigKey("friction_down"),
    )
    least: ClassVar[Mapping[str, float]] = dict.fromkeys(
        ("stiffness", "friction_up", "friction_down"), 0.0
    )
    units: ClassVar[Mapping[str, str]] = {**UNITS, "friction_up": "N·m", "friction_down": "N·m"}

    friction_up: float
    friction_down: float
