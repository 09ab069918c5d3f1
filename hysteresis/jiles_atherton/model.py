"""The Jiles-Atherton model of a joint's resistant torque."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...published import LI_TABLE_2
from ..certificate import ALL_ANGLES, ROUNDING, Certificate, checked_range
from ..protocol import ConfigKey, HysteresisModel, State, read_only
from . import kernels
from ._forms import CLAMPS, FORMS
from .margins import margin_everywhere, margin_in_range

AngleUnit = Literal["rad", "deg"]
Form = Literal["bulk", "original", "derivative", "jiles-1992"]
Clamp = Literal["none", "jiles", "irreversible"]
PARAMETERS = ("Ms", "a", "alpha", "c", "k")
DEGREE = math.pi / 180
UNIT_PER_RADIAN: dict[str, float] = {"rad": 1.0, "deg": 180 / math.pi}


@dataclass(frozen=True, kw_only=True)
class JilesAtherton(HysteresisModel):
    """Hysteretic resistance M of a joint, driven by its angle H (Li et al. 2022, eq. 1-4).

    With He = H + alpha M, Man = Ms (coth(He/a) - a/He) and delta = sign(dH),

        dM/dH = f / (1 - alpha f),    f = (Man - M) / (delta k) + c dMan/dHe.

    This is eq. (4) of the paper (the "bulk" form, Venkataraman and Krishnaprasad 1998), without
    the clamp of magnetics: a joint needs c > 1, where that clamp makes the torque run away.
    In a closed cycle the joint loses (c - 1) times a number that is never negative: c > 1 resists
    the motion, c = 1 is elastic, c < 1 drives the motion. The other forms and clamps are those of
    magnetics; each form has other loops for the same five numbers.

    Attributes:
        Ms: Saturation torque, > 0 [N·m].
        a: Shape parameter, > 0 [angle_unit].
        alpha: Coupling of torque into the effective angle [angle_unit per N·m].
        c: Reversibility, >= 1 unless `allow_active`.
        k: Loss parameter, > 0 [angle_unit].
        angle_unit: Unit of a, k and alpha. The published sets are in degrees; the angles that the
            methods take are in radians in either case.
        form: Equation of the model: `bulk`, `original` (Jiles and Atherton 1986), `derivative`
            (with dMan/dHe for dMan/dH) or `jiles-1992`; all but `bulk` drive the joint.
        clamp: Rule that stops the irreversible part against the motion: `none`, `jiles` (by the
            sign of Man - M) or `irreversible` (by the sign of that part, right for c > 1).
        allow_active: Whether to accept a model that feeds energy into the joint.
    """

    name: ClassVar[str] = "jiles-atherton"
    kernels: ClassVar[Any] = kernels
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (
        *map(ConfigKey, PARAMETERS),
        ConfigKey("angle_unit", "word", get_args(AngleUnit)),
        ConfigKey("form", "word", FORMS, optional=True),
        ConfigKey("clamp", "word", CLAMPS, optional=True),
    )

    Ms: float
    a: float
    alpha: float
    c: float
    k: float
    angle_unit: AngleUnit = "rad"
    form: Form = "bulk"
    clamp: Clamp = "none"
    allow_active: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("Ms", "a", "k"):
            value = getattr(self, name)
            if value <= 0:
                raise self._wrong(name, "give a number above 0")
            if not kernels.SMALLEST <= value <= 1 / kernels.SMALLEST:
                raise self._wrong(name, "give a number from 1e-100 to 1e+100; choose another unit")
        most = 1 if self.form == "jiles-1992" else math.inf
        if self.form != "bulk" and not 0 <= self.c < most:
            raise self._wrong("c", "give a number of at least 0 (below 1 for form jiles-1992)")
        if self.allow_active:
            return
        if self.form != "bulk":
            raise InputError(
                f"form is {self.form!r}: this form feeds energy into the joint with any "
                "parameters; use 'bulk' with c >= 1, or allow_active=True to accept that"
            )
        if self.c < 1:
            raise InputError(
                f"parameter c is {self.c}: below 1 the model feeds energy into the joint; use "
                "c >= 1, or allow_active=True to accept that"
            )

    @classmethod
    def from_config(cls, config: Mapping[str, Any]) -> "JilesAtherton":
        """Returns the model of a value for each of `config_keys`, which may be active."""
        return cls(**config, allow_active=True)

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters as the kernels read them, in radians, with constants of every step."""
        p, scale = np.empty(kernels.PARAMETER_SIZE), DEGREE if self.angle_unit == "deg" else 1.0
        numbers = self.Ms, self.a * scale, self.alpha * scale, self.c, self.k * scale
        kernels.set_parameters(p, *numbers, FORMS.index(self.form), CLAMPS.index(self.clamp))
        return read_only(p)

    @property
    def c_source(self) -> Path:
        """File with the kernel `commit` in C99; there is none for other forms and clamps."""
        source = super().c_source
        exact = self.form == "bulk" and self.clamp == "none"
        return source if exact else source.with_name("other_forms.c")

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Proves that no motion meets the pole, where a proof exists (docs/theory.md, "Safety").

        With chi = Ms/(3a), the largest slope of Man, the lag u = M - Man never leaves
        |u| <= k |c-1| chi: at that value the decay of u outweighs the source. Hence f lies between
        -(|c-1| + max(-c, 0)) chi and (|c-1| + max(c, 0)) chi, and 1 - alpha f stays positive if it
        is positive at both ends; for c >= 1 and alpha > 0 that is alpha (2c-1) Ms / (3a) < 1.

        In a finite range of angles [rad] the longest possible run in either direction bounds u more
        tightly, so a model may be safe in a range but not at all angles. Nothing is proved (margin
        -inf) for other forms than `bulk`, and for a clamp.
        """
        low, high = checked_range(angle_range)
        Ms, a, alpha, c, k = self.parameter_vector[: len(PARAMETERS)].tolist()
        margin, memory_bound = margin_everywhere(Ms, a, alpha, c, k)
        largest = memory_bound
        if not kernels.is_exact(self._parameters):
            margin = -math.inf
        elif margin <= ROUNDING and math.isfinite(high - low):
            margin, memory_bound, largest = margin_in_range(low, high, Ms, a, alpha, c, k)
        return Certificate(
            margin=margin,
            dissipative=margin > ROUNDING and c >= 1,
            torque_bound=Ms + largest,
            memory_bound=memory_bound,
            angle_range=(low, high),
        )

    def anhysteretic(self, state: State) -> float:
        """Returns Man [N·m], the torque towards which the memory of `state` relaxes."""
        return float(state.memory[kernels.MAN])

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's; certified, M / Ms stays."""
        torque = float(memory[kernels.TORQUE]) * self.Ms / float(parameters[kernels.MS])
        torque = self._covered(float(memory[kernels.ANGLE]), torque)
        return self._at_torque(torque, memory, parameters)

    def in_unit(self, angle_unit: AngleUnit) -> "JilesAtherton":
        """Returns the same model with a, k and alpha expressed in `angle_unit`."""
        if angle_unit not in UNIT_PER_RADIAN:
            raise InputError(f"angle_unit is {angle_unit!r}: use 'rad' or 'deg'")
        factor = UNIT_PER_RADIAN[angle_unit] / UNIT_PER_RADIAN[self.angle_unit]
        return replace(self.scaled(angle=factor), angle_unit=angle_unit)

    @property
    def least(self) -> Mapping[str, float]:  # type: ignore[override]
        """Lower bounds of parameters; a model that may feed energy into a joint has no c >= 1."""
        lowest = (-math.inf if self.form == "bulk" else 0.0) if self.allow_active else 1.0
        return {"Ms": 0.0, "a": 0.0, "c": lowest, "k": 0.0}

    @property
    def units(self) -> Mapping[str, str]:  # type: ignore[override]
        """Units of the parameters, by name; a pure number has no entry."""
        unit = self.angle_unit
        return {"Ms": "N·m", "a": unit, "alpha": f"{unit}/N·m", "k": unit}

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; most defaults are left out."""
        content = super().to_dict()
        for field in fields(self):
            if content[field.name] == field.default and field.name != "angle_unit":
                del content[field.name]
        return content


TABLE_2: dict[str, JilesAtherton] = {
    name: JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    for name, (Ms, a, alpha, c, k) in LI_TABLE_2.items()
}
"""Suit joints as identified by Li et al. 2022, Table 2: by joint and optimizer, in degrees."""
