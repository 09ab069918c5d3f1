"""`Clipped`: any hysteresis model, with its torque constant outside a range of angles."""

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import number
from ...errors import InputError, shown
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..protocol import Energy, HysteresisModel, State, finite_series
from .wrapper import Wrapper


@dataclass(frozen=True, kw_only=True)
class Clipped(Wrapper):
    """A model inside a range of angles; outside, the torque keeps its value at the range's end.

    The inner model follows the angle clipped to the range, which is constant extrapolation:
    Simulink's lookup tables call it "clip". It is not called "clamped" here, because `clamp`
    already names the rule of magnetics in `JilesAtherton`.

    A model that was identified in a range of angles says nothing about the torque outside it, and
    many models are certified in a range only. The inner model never leaves the range, so its
    certificate for the range holds at all angles here. The constant torque outside is conservative:
    it dissipates nothing. But it does not decay, and has no equilibrium outside: where the torque
    at the end of the range is not zero, an arm that hangs or lies outside is pushed for ever, as if
    a constant weight pulled at the joint. A real suit's joint has an equilibrium angle of its own.
    If an arm goes beyond the range, measure there, or use a model that is certified at all angles.

    Attributes:
        model: Inner model, neither `Clipped` nor `Asymmetric`. A `Clipped` model can be made
            asymmetric, but not the other way round.
        angle_range: Lowest and highest angle that the inner model follows [rad].

    Raises:
        InputError: The range is not two finite ascending angles, or `model` is itself a wrapper.
    """

    name = "clipped"

    not_fitted: ClassVar[tuple[str, ...]] = ("angle_range",)

    angle_range: tuple[float, float]

    def __post_init__(self) -> None:
        if not isinstance(self.model, HysteresisModel) or isinstance(self.model, Wrapper):
            raise InputError(
                f"model is {shown(self.model)}: give one hysteresis model without another around it"
            )
        low, high = checked_range(self.angle_range)
        if not math.isfinite(high - low):
            raise InputError(f"angle_range is {self.angle_range}: give two finite angles (rad)")
        object.__setattr__(self, "angle_range", (low, high))

    def response(self, angle: ArrayLike, initial_torque: float = 0.0) -> Array:
        """Computes the resistance along a sequence of angles; see `HysteresisModel.response`."""
        angle = finite_series("angle", angle, "rad")
        return self.model.response(np.clip(angle, *self.angle_range), initial_torque)

    def start(self, angle: float, torque: float = 0.0) -> State:
        """Begins a motion at `angle` [rad] with a known resistance [N·m]."""
        number("angle", angle, "rad")
        return replace(self.model.start(self._inside(angle), torque), angle=float(angle))

    def step(self, state: State, angle: float) -> tuple[State, float]:
        """Moves on to `angle` [rad]; steps give the same torques as `response`, bit for bit."""
        number("angle", angle, "rad")
        inner, torque = self.model.step(state, self._inside(angle))
        return replace(inner, angle=float(angle)), torque

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory in place of another model's, with a torque that is certified here."""
        carried = self.model.carry_over(memory, parameters)
        if self.start_is_certified(State(carried, float(carried[0]), float(carried[1]))):
            return carried
        torque = self._covered(float(carried[0]), float(carried[1]))
        return self.model._at_torque(torque, memory, parameters)

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves many memories on, in place; see `HysteresisModel.advance`."""
        inside = (np.clip(angles, *self.angle_range) for angles in (angle, soon))
        return self.model.advance(memories, *inside)

    def tangent(self, state: State, direction: float) -> float:
        """Returns the stiffness [N·m/rad] with which a motion goes on; 0 outside the range."""
        low, high = self.angle_range
        outside = state.angle >= high if direction > 0 else state.angle <= low
        beyond = not low <= state.angle <= high
        return 0.0 if outside or beyond else self.model.tangent(state, direction)

    def energy(self, state: State) -> Energy:
        """Returns stored and dissipated energy [J]; outside the range all work is stored."""
        stored, dissipated = self.model.energy(state)
        return Energy(stored + state.memory[1] * (state.angle - state.memory[0]), dissipated)

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the inner model's certificate for its own range, which holds at all angles."""
        asked = checked_range(angle_range)
        return replace(self.model.certificate(self.angle_range), angle_range=asked)

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> "Clipped":
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta."""
        low, high = self.angle_range
        inner = self.model.scaled(torque=torque, angle=angle)
        return Clipped(model=inner, angle_range=(low * angle, high * angle))

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: those of the inner model; the curves give the range."""
        return self.model.free_parameters

    @property
    def units(self) -> dict[str, str]:
        """Units of the parameters, by name; a pure number has no entry."""
        return {"angle_range": "rad"}

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; `model_from_dict` gives the model back."""
        return {**super().to_dict(), "angle_range": list(self.angle_range)}

    def _inside(self, angle: float) -> float:
        return min(max(float(angle), self.angle_range[0]), self.angle_range[1])
