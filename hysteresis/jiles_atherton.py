"""The Jiles-Atherton model of a joint's resistant torque."""

import math
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from . import _jiles_atherton_kernels as kernels
from .certificate import Certificate, PoleError

AngleUnit = Literal["rad", "deg"]
PARAMETERS = ("Ms", "a", "alpha", "c", "k")
UNIT_PER_RADIAN: dict[str, float] = {"rad": 1.0, "deg": 180 / math.pi}


class JilesAthertonState(NamedTuple):
    """The whole memory of the model: the last angle [rad] and the torque [N·m] there."""

    angle: float
    torque: float


@dataclass(frozen=True, kw_only=True)
class JilesAtherton:
    """Hysteretic resistance M of a joint, driven by its angle H (Li et al. 2022, eq. 1-4).

    With He = H + alpha M, Man = Ms (coth(He/a) - a/He) and delta = sign(dH),

        dM/dH = f / (1 - alpha f),    f = (Man - M) / (delta k) + c dMan/dHe.

    This is eq. (4) of the paper (the "bulk" form, Venkataraman and Krishnaprasad 1998), without
    the clamp of magnetics: a joint needs c > 1, where that clamp makes the torque run away.
    In a closed cycle the joint loses (c - 1) times a number that is never negative: c > 1 resists
    the motion, c = 1 is elastic, c < 1 drives it.

    Attributes:
        Ms: saturation torque [N·m], > 0.
        a: shape parameter [angle_unit], > 0.
        alpha: coupling of torque into the effective angle [angle_unit per N·m].
        c: reversibility, >= 1 unless `allow_active`.
        k: loss parameter [angle_unit], > 0.
        angle_unit: unit of a, k and alpha. The published sets are in degrees; angles that go into
            the methods are radians whatever it is.
        allow_active: accept c < 1, a model that feeds energy into the joint.

    Raises:
        InputError: a parameter is not finite or out of its range.
    """

    Ms: float
    a: float
    alpha: float
    c: float
    k: float
    angle_unit: AngleUnit = "rad"
    allow_active: bool = False

    def __post_init__(self) -> None:
        if self.angle_unit not in UNIT_PER_RADIAN:
            raise InputError(f"angle_unit is {self.angle_unit!r}: use 'rad' or 'deg'")
        for name in PARAMETERS:
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float, np.number)):
                raise InputError(f"parameter {name} is {value!r}: give a number")
            if not math.isfinite(value):
                raise InputError(f"parameter {name} is {value}: give a finite number")
            object.__setattr__(self, name, float(value))
        for name in ("Ms", "a", "k"):
            if getattr(self, name) <= 0:
                raise InputError(f"parameter {name} is {getattr(self, name)}: it must be above 0")
        if self.c < 1 and not self.allow_active:
            raise InputError(
                f"parameter c is {self.c}: below 1 the model feeds energy into the joint; use "
                "c >= 1, or allow_active=True if that is what you want"
            )

    def response(self, angle: ArrayLike, initial_torque: float = 0.0) -> NDArray[np.float64]:
        """Computes the resistance along a sequence of angles.

        The result depends on the order of the angles, not on time. Between two samples the motion
        is taken as monotone; a repeated angle repeats its torque.

        Args:
            angle: joint angles [rad], shape (n,).
            initial_torque: resistance at angle[0] [N·m].

        Returns:
            Resistance [N·m], shape (n,), with torque[0] == initial_torque.

        Raises:
            InputError: `angle` is not one finite series.
            PoleError: the motion meets the pole of an uncertified model.
        """
        angle = np.ascontiguousarray(angle, dtype=np.float64)
        if angle.ndim != 1 or angle.size == 0:
            raise InputError(f"angle has shape {angle.shape}: give one series of at least 1 sample")
        if not np.isfinite(angle).all():
            bad = int(np.flatnonzero(~np.isfinite(angle))[0])
            raise InputError(f"angle[{bad}] is {angle[bad]}: angles must be finite (rad)")
        torque = np.empty_like(angle)
        kernels.response(angle, _finite_torque(initial_torque), *self.kernel_arguments, torque)
        if np.isnan(torque[-1]):
            last = int(np.flatnonzero(np.isnan(torque))[0])
            raise self._pole(angle[last - 1], angle[last], f" (sample {last})")
        return torque

    def start(self, angle: float, torque: float = 0.0) -> JilesAthertonState:
        """Begins a motion at `angle` [rad] with a known resistance [N·m]."""
        if not math.isfinite(angle):
            raise InputError(f"angle is {angle}: give a finite angle (rad)")
        return JilesAthertonState(float(angle), _finite_torque(torque))

    def step(self, state: JilesAthertonState, angle: float) -> tuple[JilesAthertonState, float]:
        """Moves on to `angle` [rad]; the incremental twin of `response`, bit for bit.

        Returns:
            The new state and the resistance [N·m] there.

        Raises:
            InputError: `angle` is not finite.
            PoleError: the motion meets the pole of an uncertified model.
        """
        if not math.isfinite(angle):
            raise InputError(f"angle is {angle}: give a finite angle (rad)")
        torque, _ = kernels.advance(*state, float(angle), *self.kernel_arguments)
        if math.isnan(torque):
            raise self._pole(state.angle, angle)
        return JilesAthertonState(float(angle), torque), torque

    def tangent(self, state: JilesAthertonState, direction: float) -> float:
        """Returns the stiffness dM/dH [N·m/rad] of a motion that goes on with sign `direction`."""
        delta = math.copysign(1.0, direction)
        return kernels.tangent_stiffness(*state, delta, *self.kernel_arguments[:5])

    def certificate(self) -> Certificate:
        """Proves, where it can be proved, that no motion meets the pole (see the README, "Safety").

        With chi = Ms/(3a), the largest slope of Man, u = M - Man obeys |u| <= k |c-1| chi for ever
        once it does: at that value its decay outweighs its source. Hence f lies between
        -(|c-1| + max(-c, 0)) chi and (|c-1| + max(c, 0)) chi, and 1 - alpha f stays positive when
        it does at both ends; for c >= 1 and alpha > 0 that is alpha (2c-1) Ms / (3a) < 1.
        """
        margin, memory_bound = kernels.certificate(*self.kernel_arguments[:5])
        return Certificate(
            margin=margin,
            dissipative=margin > 0 and self.c >= 1,
            memory_bound=memory_bound,
            torque_bound=self.Ms + memory_bound,
        )

    def anhysteretic(self, state: JilesAthertonState) -> float:
        """Returns Man [N·m], the torque towards which the memory of `state` relaxes."""
        return kernels.anhysteretic(*state, *self.kernel_arguments[:3])

    def scaled(self, *, torque: float) -> "JilesAtherton":
        """Returns the model whose every response is `torque` (> 0) times this one's, exactly.

        Ms -> torque Ms, alpha -> alpha / torque. With torque = P / P0 this is the pressure scaling
        of the volume effect.
        """
        if not (math.isfinite(torque) and torque > 0):
            raise InputError(f"torque scale is {torque}: give a finite number above 0")
        return replace(self, Ms=self.Ms * torque, alpha=self.alpha / torque)

    def in_unit(self, angle_unit: AngleUnit) -> "JilesAtherton":
        """Returns the same model with a, k and alpha expressed in `angle_unit`."""
        if angle_unit not in UNIT_PER_RADIAN:
            raise InputError(f"angle_unit is {angle_unit!r}: use 'rad' or 'deg'")
        scale = UNIT_PER_RADIAN[angle_unit] / UNIT_PER_RADIAN[self.angle_unit]
        a, k, alpha = self.a * scale, self.k * scale, self.alpha * scale
        return replace(self, a=a, k=k, alpha=alpha, angle_unit=angle_unit)

    def to_dict(self) -> dict[str, Any]:
        """Returns the constructor's arguments; `JilesAtherton(**d)` gives the model back."""
        return asdict(self)

    @cached_property
    def kernel_arguments(self) -> tuple[float, float, float, float, float, float]:
        """Ms, a, alpha, c, k in radians and the longest internal step, for the kernels."""
        scale = 1 / UNIT_PER_RADIAN[self.angle_unit]
        parameters = (self.Ms, self.a * scale, self.alpha * scale, self.c, self.k * scale)
        return *parameters, kernels.field_step_limit(*parameters)

    def _pole(self, start: float, end: float, where: str = "") -> PoleError:
        return PoleError(
            f"the torque becomes infinite between {start:.6g} and {end:.6g} rad{where}; the "
            f"model's certificate margin is {self.certificate().margin:.3g} and must be above 0 "
            "for arbitrary motions"
        )


def _finite_torque(torque: float) -> float:
    if not math.isfinite(torque):
        raise InputError(f"initial torque is {torque}: give a finite torque (N·m)")
    return float(torque)
