"""Models around another model, which add to its torque or change the angle that it follows."""

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import zip_longest
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.polynomial import polynomial as poly
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import number
from ...errors import InputError, shown
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..polynomial import coefficients, extremes
from ..protocol import POLYNOMIAL, Energy, HysteresisModel, Numbers, State, finite_series
from . import backlash_kernels as backlash
from . import viscoelastic_kernels as viscoelastic


@dataclass(frozen=True, kw_only=True)
class Wrapper(HysteresisModel):
    """A model around an inner model, whose kernels, parameters and memory it uses.

    Attributes:
        model: Inner model.
    """

    place: ClassVar[str]
    """Config key in MJCF, and field of `Parts`, for the numbers of the class."""
    remembered: ClassVar[int] = 0
    """How many numbers the class remembers in a state of the engine."""
    c_state: ClassVar[int] = 0
    """How many numbers the class adds to the state in C."""

    model: HysteresisModel

    @property
    def given(self) -> list[float]:
        """The numbers of all parameters, end to end."""
        return np.concatenate([np.ravel(getattr(self, name)) for name in self.units]).tolist()

    @property
    def numbers(self) -> Array:
        """The given numbers, and zeros for those that the class remembers in a state."""
        return np.array([*self.given, *[0.0] * self.remembered])

    @property
    def kernels(self) -> ModuleType:  # type: ignore[override]
        """Kernels of the inner model."""
        return self.model.kernels

    @cached_property
    def parameter_vector(self) -> Array:
        """Parameters of the inner model, as its kernels read them."""
        return self.model.parameter_vector

    @property
    def memory_size(self) -> int:  # type: ignore[override]
        """How many numbers the memory holds, which is that of the inner model."""
        return self.model.memory_size

    @property
    def c_source(self) -> Path:
        """File with the C99 code of this class around its inner model, NAME.c beside the class."""
        return Path(str(sys.modules[type(self).__module__].__file__)).with_name(f"{self.name}.c")

    def _check_inside(self, *allowed: type["Wrapper"], words: str) -> None:
        """Checks that the inner model is bare, or one of the allowed wrappers."""
        refused = isinstance(self.model, Wrapper) and not isinstance(self.model, allowed)
        if not isinstance(self.model, HysteresisModel) or refused:
            raise InputError(f"model is {shown(self.model)}: give one {words}")

    def _begin(self, angle: float, torque: float) -> Array:
        return self.model._begin(angle, torque)

    def _follow(self, memory: Array, angles: Array, torque: float) -> Array:
        return self.model._follow(memory, angles, torque)

    def _move(self, memory: Array, angle: float) -> float:
        return self.model._move(memory, angle)

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves memories; see `HysteresisModel.advance`."""
        return self.model.advance(memories, angle, soon)

    def tangent(self, state: State, direction: float) -> float:
        """Returns the stiffness [N·m/rad] of a motion that goes on with the sign `direction`."""
        return self.model.tangent(state, direction)

    def energy(self, state: State) -> Energy:
        """Returns the energy that the inner model has stored and dissipated [J]."""
        return self.model.energy(self._inner(state))

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's; see `HysteresisModel.carry_over`."""
        return self.model.carry_over(memory, parameters)

    def anhysteretic(self, state: State) -> float | None:
        """Returns the torque [N·m] that the inner model relaxes to; see `HysteresisModel`."""
        return self.model.anhysteretic(self._inner(state))

    def _inner(self, state: State) -> State:
        """Returns the state of the inner model."""
        return state

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> Self:
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta."""
        inner = self.model.scaled(torque=torque, angle=angle)
        return replace(super().scaled(torque=torque, angle=angle), model=inner)

    @property
    def free_parameters(self) -> int:
        """How many numbers of the inner model and of this class a fit chooses."""
        return self.model.free_parameters + super().free_parameters

    def to_dict(self) -> dict[str, Any]:
        """Returns name, inner model and parameters, ready for JSON."""
        own = super().to_dict()
        return {"model": own.pop("model"), "hysteresis": self.model.to_dict(), **own}


@dataclass(frozen=True, kw_only=True)
class Clipped(Wrapper):
    """A model inside a range of angles; outside, the torque keeps its value at the range's end.

    The inner model follows the angle clipped to the range. Simulink's lookup tables call this
    constant extrapolation "clip"; `clamp` is the rule of magnetics in `JilesAtherton`.

    A model that was identified in a range of angles says nothing about the torque outside, and many
    models are certified in a range only. The inner model never leaves the range, so the certificate
    for the range holds at all angles here. The constant torque outside dissipates nothing. But that
    torque does not decay: where the torque at the end of the range is not zero, an arm outside is
    pushed for ever, as by a constant weight. A real suit's joint has an equilibrium angle. If an
    arm goes beyond the range, measure there, or use a model that is certified at all angles.

    Attributes:
        model: Inner model, neither `Clipped` nor `Asymmetric`. A `Clipped` model can be made
            asymmetric, but not the other way round.
        angle_range: Lowest and highest angle that the inner model follows [rad].
    """

    name = "clipped"
    place = "angle_range"
    not_fitted: ClassVar[tuple[str, ...]] = ("angle_range",)
    units: ClassVar[Mapping[str, str]] = {"angle_range": "rad"}

    angle_range: tuple[float, float]

    def __post_init__(self) -> None:
        self._check_inside(words="hysteresis model without another around it")
        low, high = checked_range(self.angle_range)
        if not math.isfinite(high - low):
            raise InputError(f"angle_range is {self.angle_range}: give two finite angles (rad)")
        object.__setattr__(self, "angle_range", (low, high))

    def _begin(self, angle: float, torque: float) -> Array:
        return self.model._begin(self._inside(angle), torque)

    def _follow(self, memory: Array, angles: Array, torque: float) -> Array:
        return self.model._follow(memory, np.clip(angles, *self.angle_range), torque)

    def _move(self, memory: Array, angle: float) -> float:
        return self.model._move(memory, self._inside(angle))

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's, with a torque that is certified."""
        carried = self.model.carry_over(memory, parameters)
        if self.start_is_certified(State(carried, float(carried[0]), float(carried[1]))):
            return carried
        torque = self._covered(float(carried[0]), float(carried[1]))
        return self.model._at_torque(torque, memory, parameters)

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves memories; see `HysteresisModel.advance`."""
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

    def _inside(self, angle: float) -> float:
        return min(max(angle, self.angle_range[0]), self.angle_range[1])


@dataclass(frozen=True, kw_only=True)
class Asymmetric(Wrapper):
    """A model plus a history-independent torque: T = model(theta) + sum p_i theta^i.

    Measured loops of suit joints are not symmetric (Li et al. 2022, section 5.2), but the loops of
    most models are. The polynomial bends the loop but does not change the dissipated energy,
    because the work of the polynomial depends on the first and last angle only.

    Attributes:
        model: Hysteretic part, any model that is not asymmetric itself.
        polynomial: Coefficients p_0, p_1, ..., at most six [N·m/rad^i].
    """

    name = "asymmetric"
    place = "polynomial"
    units: ClassVar[Mapping[str, str]] = {"polynomial": POLYNOMIAL}

    polynomial: Numbers

    def __post_init__(self) -> None:
        self._check_inside(Clipped, words="hysteresis model, bare or `Clipped`")
        object.__setattr__(self, "polynomial", coefficients("polynomial", self.polynomial))

    def elastic(self, angle: ArrayLike) -> Array:
        """Returns the torque [N·m] of the polynomial at angles [rad]."""
        angles = np.asarray(angle, dtype=np.float64)
        return np.asarray(poly.polyval(angles, np.array(self.polynomial)), dtype=np.float64)

    def _begin(self, angle: float, torque: float) -> Array:
        return self.model._begin(angle, torque - float(self.elastic(angle)))

    def _follow(self, memory: Array, angles: Array, torque: float) -> Array:
        elastic = self.elastic(angles)
        torques = self.model._follow(memory, angles, torque - elastic[0]) + elastic
        torques[0] = torque
        return torques

    def _move(self, memory: Array, angle: float) -> float:
        return self.model._move(memory, angle) + float(self.elastic(angle))

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves memories; see `HysteresisModel.advance`."""
        return self.model.advance(memories, angle, soon) + self.elastic(soon)

    def tangent(self, state: State, direction: float) -> float:
        """Returns the stiffness [N·m/rad] of a motion that goes on with sign `direction`."""
        slope = poly.polyval(state.angle, poly.polyder(np.array(self.polynomial)))
        return self.model.tangent(state, direction) + float(slope)

    def energy(self, state: State) -> Energy:
        """Returns stored and dissipated energy [J]; the polynomial stores its work from angle 0."""
        stored, dissipated = self.model.energy(state)
        bend = poly.polyval(state.angle, poly.polyint(np.array(self.polynomial)))
        return Energy(stored + float(bend), dissipated)

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate of the hysteretic part, with a larger torque bound.

        The bound grows by the largest |polynomial| in the range.
        """
        low, high = checked_range(angle_range)
        inner = self.model.certificate((low, high))
        largest = max(map(abs, extremes(self.polynomial, low, high)))
        return replace(inner, torque_bound=inner.torque_bound + largest)


def sprung(model: HysteresisModel, offset: float, stiffness: float) -> HysteresisModel:
    """Returns the model plus the torque offset [N·m] + stiffness [N·m/rad] * angle.

    An `Asymmetric` model, also inside another, gets the line added to its polynomial.
    """
    line = [offset, stiffness]
    if isinstance(model, Wrapper) and not isinstance(model, Asymmetric | Clipped):
        return replace(model, model=sprung(model.model, offset, stiffness))
    if not isinstance(model, Asymmetric):
        return Asymmetric(model=model, polynomial=line)
    terms = zip_longest(model.polynomial, line, fillvalue=0.0)
    return Asymmetric(model=model.model, polynomial=[float(p) + q for p, q in terms])


@dataclass(frozen=True, kw_only=True)
class Backlash(Wrapper):
    """A model behind a gap between the joint and the suit, also called lost motion.

    The joint at the angle theta touches the suit's side, at an angle y, on one of two faces:
    theta - gap/2 <= y <= theta + gap/2. The torque is T = model(y), and contact can only push:
    T > 0 where y = theta - gap/2, T < 0 where y = theta + gap/2, and T = 0 in between. So contact
    opens where the torque has fallen to zero, the suit's side rests there, and the joint moves
    freely until contact on the other face. This is the play of a transmission that carries contact
    forces only (Nordin and Gutman 2002, Automatica 38, with a hysteresis model in place of the
    shaft).

    Work is done only where y moves with theta, so a motion of the joint does at least the work that
    the model takes: `dissipative` of the certificate is that of the inner model. Play at the input
    alone, T = model(play(theta)) as in stacked play operators, is not offered: at a reversal the
    joint would go back by the gap at constant torque, and gain energy that was never stored.

    Where the torque of the model falls with rising angle (as a polynomial can), the suit's side may
    snap from one face to the other, and the impact dissipates the energy that is released.

    Attributes:
        model: Model of the suit's side, which may be `Clipped` and `Asymmetric`. A model behind
            play can have a dashpot beside it (`Viscoelastic`), but not the other way round.
        gap: Angle by which the joint can move without torque, > 0 [rad].
    """

    name = "backlash"
    place = "gap"
    remembered = backlash.SIZE - backlash.END
    least: ClassVar = MappingProxyType({"gap": 0.0})
    units: ClassVar[Mapping[str, str]] = {"gap": "rad"}
    c_state: ClassVar[int] = 2

    gap: float

    def __post_init__(self) -> None:
        words = "model, bare, `Clipped` or `Asymmetric`; put a dashpot around the play, not behind"
        self._check_inside(Asymmetric, Clipped, words=f"{words} it")
        gap = number("gap", self.gap, "rad")
        if gap <= 0:
            raise InputError(f"gap is {gap:g} rad: give an angle above 0, or the inner model alone")
        object.__setattr__(self, "gap", gap)

    @property
    def memory_size(self) -> int:  # type: ignore[override]
        """How many numbers the memory holds: that of the inner model, and the suit's angle."""
        return self.model.memory_size + 1

    @cached_property
    def _around(self) -> tuple[Array, Array]:
        """Polynomial and range of the inner model, as the kernels have them."""
        around = parts(self.model)
        return around.polynomial, around.angle_range

    def _begin(self, angle: float, torque: float) -> Array:
        """Begins in contact, or without torque in the middle of the gap; returns the memory."""
        end = backlash.begun(self.gap, angle, torque)
        return np.append(self.model._begin(end, torque), end)

    def _follow(self, memory: Array, angles: Array, torque: float) -> Array:
        play, torques = np.array([self.gap, memory[-1]]), np.empty(angles.size)
        torques[0] = torque
        follow = backlash.follower(self.kernels)
        follow(self._parameters, memory[:-1], *self._around, play, angles, torques)
        memory[-1] = play[backlash.END]
        return torques

    def _move(self, memory: Array, angle: float) -> float:
        return float(self._follow(memory, np.array([np.nan, angle]), 0.0)[1])

    advance = HysteresisModel.advance

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's; the suit's side keeps its angle."""
        return np.append(self.model.carry_over(memory[:-1], parameters), memory[-1])

    def suit_state(self, state: State) -> State:
        """Returns the state of the model inside, at the angle of the suit's side [rad]."""
        return State(state.memory[:-1], float(state.memory[-1]), state.torque)

    _inner = suit_state

    def tangent(self, state: State, direction: float) -> float:
        """Returns the stiffness [N·m/rad] with which a motion goes on; 0 inside the gap."""
        end, delta = state.memory[-1], math.copysign(1.0, direction)
        if backlash.is_free(state.torque, np.array([self.gap, end]), end, state.angle, delta):
            return 0.0
        return self.model.tangent(self.suit_state(state), direction)

    def start_is_certified(self, state: State) -> bool:
        """Returns whether the certificate covers motions that start in `state`."""
        return self.model.start_is_certified(self.suit_state(state))

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate of the inner model, half a gap beyond the range on each side."""
        low, high = checked_range(angle_range)
        inner = self.model.certificate((low - self.gap / 2, high + self.gap / 2))
        return replace(inner, angle_range=(low, high))


@dataclass(frozen=True, kw_only=True)
class Viscoelastic(Wrapper):
    """A model beside two elements whose torque depends on the rate.

    T = model(theta) + b dtheta/dt + T_r, with dT_r/dt = k dtheta/dt - T_r / tau: a dashpot, and a
    spring in series with another (a Maxwell element), in parallel with the model. Together with an
    elastic spring these three are the standard linear solid (Findley, Lai and Onaran 1976, chapter
    5). Both elements are passive: in every closed cycle, at any speed, they dissipate energy in
    addition to that of the model. Both are relaxed where a motion begins.

    In an infinitely slow motion both torques vanish. All methods without time assume such a motion:
    `step`, `advance`, `tangent`, `energy`, `inverse`, and `response` without times. A simulation
    includes both torques, as does `response` with times, to the first order of the time step.

    Attributes:
        model: Model that does not depend on the rate; it may be `Clipped`, `Asymmetric` and behind
            play.
        damping: Damping b of the dashpot [N·m·s/rad].
        relaxation_stiffness: Stiffness k of the Maxwell element [N·m/rad].
        relaxation_time: Time tau in which the Maxwell element's torque decays to 1/e [s].
    """

    name = "viscoelastic"
    place = "viscoelastic"
    remembered = viscoelastic.SIZE - viscoelastic.NUMBERS
    least: ClassVar = MappingProxyType(
        {"damping": 0.0, "relaxation_stiffness": 0.0, "relaxation_time": 0.0}
    )
    units: ClassVar[Mapping[str, str]] = {
        "damping": "N·m·s/rad",
        "relaxation_stiffness": "N·m/rad",
        "relaxation_time": "s",
    }
    c_state: ClassVar[int] = 2

    damping: float = 0.0
    relaxation_stiffness: float = 0.0
    relaxation_time: float = 0.0

    def __post_init__(self) -> None:
        words = "hysteresis model, not viscoelastic itself"
        self._check_inside(Asymmetric, Backlash, Clipped, words=words)
        for name in self.least:
            value = number(name, getattr(self, name), self.units[name])
            if value < 0:
                raise InputError(f"{name} is {value:g} {self.units[name]}: give at least 0")
            object.__setattr__(self, name, value)
        if self.relaxation_stiffness > 0 and self.relaxation_time == 0:
            raise InputError(
                "relaxation_time is 0 s: give a time above 0, or a relaxation_stiffness of 0"
            )

    def response(
        self, angle: ArrayLike, initial_torque: float = 0.0, time: ArrayLike | None = None
    ) -> Array:
        """Computes the resistance along a sequence of angles.

        Args:
            angle: Joint angles [rad], shape (n,).
            initial_torque: Resistance of the model at angle[0], without damping [N·m].
            time: Time of each angle, ascending [s], shape (n,), or None for an infinitely slow
                motion. The rate is the difference of neighbors (second order); the Maxwell element
                is solved exactly for the constant rate between two samples.

        Returns:
            Resistance [N·m], shape (n,).

        Raises:
            PoleError: The motion meets the pole of an uncertified model.
        """
        torque = super().response(angle, initial_torque)
        return torque if time is None else torque + self.rate_torque(angle, time)

    def rate_torque(self, angle: ArrayLike, time: ArrayLike) -> Array:
        """Computes the torque of both elements [N·m] from angles [rad] and ascending times [s]."""
        angle, time = finite_series("angle", angle, "rad"), finite_series("time", time, "s")
        if time.size != angle.size:
            raise InputError(f"time has {time.size} samples and angle {angle.size}: give as many")
        back = np.flatnonzero(np.diff(time) <= 0)
        if back.size:
            raise InputError(
                f"time[{back[0] + 1}] is {time[back[0] + 1]:g} s after {time[back[0]]:g} s: give "
                "ascending times"
            )
        torque = np.empty_like(angle)
        viscoelastic.follow(self.numbers, time, angle, torque)
        return torque + (self.damping * np.gradient(angle, time) if angle.size > 1 else 0.0)

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate of the model, with a larger torque bound.

        Both elements are passive, so `dissipative` stays. The spring of the Maxwell element never
        deflects by more than the range, which bounds that torque; a dashpot has no bound.
        """
        low, high = checked_range(angle_range)
        inner, more = self.model.certificate((low, high)), 0.0
        if self.relaxation_stiffness > 0:
            more = self.relaxation_stiffness * (high - low)
        if self.damping > 0:
            more = math.inf
        return replace(inner, torque_bound=inner.torque_bound + more)

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: those of the inner model, and all here that are not 0."""
        maxwell = 2 if self.relaxation_stiffness > 0 else 0
        return self.model.free_parameters + (self.damping > 0) + maxwell


def without_rate(model: HysteresisModel) -> HysteresisModel:
    """Returns the model inside a `Viscoelastic` one, or a model without rate as it is."""
    return model.model if isinstance(model, Viscoelastic) else model


class Parts(NamedTuple):
    """The innermost model, and the numbers of each model around; an array is empty for none.

    A state of the engine has the numbers in this order, and MJCF has these names.
    """

    bare: HysteresisModel
    polynomial: Array
    angle_range: Array
    viscoelastic: Array
    gap: Array


def parts(model: HysteresisModel) -> Parts:
    """Splits a model into the innermost model and the numbers of the models around."""
    around = {}
    while isinstance(model, Wrapper):
        around[model.place] = model.numbers
        model = model.model
    return Parts(model, *(around.get(name, np.empty(0)) for name in Parts._fields[1:]))
