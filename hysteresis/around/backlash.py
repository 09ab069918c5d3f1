"""`Backlash`: any hysteresis model behind play in the transmission."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import number, scales
from ...errors import InputError, shown
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..protocol import Energy, HysteresisModel, State, finite_series, read_only
from . import backlash_kernels as kernels
from .asymmetric import Asymmetric
from .clipped import Clipped
from .wrapper import Wrapper


@dataclass(frozen=True, kw_only=True)
class Backlash(Wrapper):
    """A model behind a gap between the joint and the suit, also called lost motion.

    The joint at the angle theta touches the suit's side, at an angle y, on one of two faces:
    theta - gap/2 <= y <= theta + gap/2. The torque is T = model(y), and contact can only push:
    T > 0 where y = theta - gap/2, T < 0 where y = theta + gap/2, and T = 0 in between. So contact
    opens where the torque has fallen to zero, the suit's side rests there, and the joint moves
    freely until it meets the other face. This is the play of a transmission that carries contact
    forces only (Nordin and Gutman 2002, Automatica 38, with a hysteresis model in place of the
    shaft).

    Work is done only where y moves with theta, so a motion of the joint does at least the work that
    the model takes: `dissipative` of the certificate is that of the inner model. Play at the input
    alone, T = model(play(theta)) as in stacked play operators, is not offered. It does not know the
    torque: at a reversal the joint would go back by the gap at constant torque, and gain energy
    that the model never stored.

    Where the torque of the model falls with its angle (a polynomial can do that), the suit's side
    may snap from one face to the other, and the impact dissipates the energy that is released.

    Attributes:
        model: Model of the suit's side, which may be `Clipped` and `Asymmetric`. A model behind
            play can have a dashpot beside it (`Viscoelastic`), but not the other way round.
        gap: Angle by which the joint can move without torque [rad].

    Raises:
        InputError: The gap is not finite or not above 0, or `model` is itself behind play or
            viscoelastic.
    """

    name = "backlash"
    least: ClassVar = MappingProxyType({"gap": 0.0})
    c_state: ClassVar[int] = 2

    gap: float

    def __post_init__(self) -> None:
        inside = (Asymmetric, Clipped)
        refused = isinstance(self.model, Wrapper) and not isinstance(self.model, inside)
        if not isinstance(self.model, HysteresisModel) or refused:
            raise InputError(
                f"model is {shown(self.model)}: give one model, bare, `Clipped` or `Asymmetric`; "
                "put a dashpot around the play, not behind it"
            )
        gap = number("gap", self.gap, "rad")
        if gap <= 0:
            raise InputError(f"gap is {gap:g} rad: give an angle above 0, or the model without it")
        object.__setattr__(self, "gap", gap)

    @property
    def memory_size(self) -> int:
        """How many numbers the memory holds: that of the inner model, and the suit's angle."""
        return self.model.memory_size + 1

    @cached_property
    def _around(self) -> tuple[Array, Array]:
        """Polynomial and range of the inner model, as the kernels have them."""
        model, polynomial, limits = self.model, np.empty(0), np.empty(0)
        if isinstance(model, Asymmetric):
            model, polynomial = model.model, np.array(model.polynomial)
        if isinstance(model, Clipped):
            limits = np.array(model.angle_range)
        return polynomial, limits

    def _follow(self, memory: Array, angles: Array, torque: float) -> Array:
        """Moves a memory on, in place; returns the torque at each angle [N·m], NaN from a pole."""
        play, torques = np.array([self.gap, memory[-1]]), np.empty(angles.size)
        torques[0] = torque
        follow = kernels.follower(self.kernels)
        follow(self._parameters, memory[:-1], *self._around, play, angles, torques)
        memory[-1] = play[kernels.END]
        return torques

    def response(self, angle: ArrayLike, initial_torque: float = 0.0) -> Array:
        """Computes the resistance along a sequence of angles; see `HysteresisModel.response`.

        A motion that begins with a torque begins in contact, one without in the middle of the gap.
        """
        angle = finite_series("angle", angle, "rad")
        memory = self.start(angle[0], initial_torque).memory.copy()
        torque = self._follow(memory, angle, float(initial_torque))
        if np.isnan(torque[-1]):
            last = int(np.flatnonzero(np.isnan(torque))[0])
            raise self._pole(angle[last - 1], angle[last], f" (sample {last})")
        return torque

    def start(self, angle: float, torque: float = 0.0) -> State:
        """Begins a motion at `angle` [rad] with a known resistance [N·m]."""
        number("angle", angle, "rad")
        number("initial torque", torque, "N·m")
        end = kernels.begun(self.gap, float(angle), float(torque))
        inner = self.model.start(end, torque)
        return State(read_only([*inner.memory, end]), float(angle), float(torque))

    def step(self, state: State, angle: float) -> tuple[State, float]:
        """Moves on to `angle` [rad]; steps give the same torques as `response`, bit for bit."""
        number("angle", angle, "rad")
        memory = state.memory.copy()
        torque = float(self._follow(memory, np.array([state.angle, angle]), state.torque)[1])
        if math.isnan(torque):
            raise self._pole(state.angle, angle)
        return State(read_only(memory), float(angle), torque), torque

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory in place of another model's; the suit's side keeps its angle."""
        return np.append(self.model.carry_over(memory[:-1], parameters), memory[-1])

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves many memories on, in place; see `HysteresisModel.advance`."""
        torque = np.empty(len(memories))
        for row, memory in enumerate(memories):
            before = float(memory[-1])
            here = self._follow(memory, np.array([np.nan, angle[row]]), 0.0)[1]
            ahead = np.array([angle[row], soon[row]])
            torque[row] = self._follow(memory.copy(), ahead, here)[1]
            if math.isnan(torque[row]):
                raise self._pole(before, float(soon[row]))
        return torque

    def suit_state(self, state: State) -> State:
        """Returns the state of the model inside, at the angle of the suit's side [rad]."""
        return State(state.memory[:-1], float(state.memory[-1]), state.torque)

    def tangent(self, state: State, direction: float) -> float:
        """Returns the stiffness [N·m/rad] with which a motion goes on; 0 where it is free."""
        end, delta = state.memory[-1], math.copysign(1.0, direction)
        if kernels.is_free(state.torque, np.array([self.gap, end]), end, state.angle, delta):
            return 0.0
        return self.model.tangent(self.suit_state(state), direction)

    def energy(self, state: State) -> Energy:
        """Returns stored and dissipated energy of the inner model [J]; the gap does neither."""
        return self.model.energy(self.suit_state(state))

    def anhysteretic(self, state: State) -> float | None:
        """Returns the torque [N·m] that the inner model relaxes to; see `HysteresisModel`."""
        return self.model.anhysteretic(self.suit_state(state))

    def start_is_certified(self, state: State) -> bool:
        """Returns whether the certificate covers motions that start in `state`."""
        return self.model.start_is_certified(self.suit_state(state))

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate of the inner model for the angles that the suit's side can reach.

        They extend half a gap beyond the range on either side.
        """
        low, high = checked_range(angle_range)
        inner = self.model.certificate((low - self.gap / 2, high + self.gap / 2))
        return replace(inner, angle_range=(low, high))

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> "Backlash":
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta."""
        scales(torque=torque, angle=angle)
        inner = self.model.scaled(torque=torque, angle=angle)
        return Backlash(model=inner, gap=self.gap * angle)

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: those of the inner model, and the gap."""
        return self.model.free_parameters + 1

    @property
    def units(self) -> dict[str, str]:
        """Units of the parameters, by name; a pure number has no entry."""
        return {"gap": "rad"}

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; `model_from_dict` gives the model back."""
        return {**super().to_dict(), "gap": self.gap}
