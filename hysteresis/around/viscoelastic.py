"""`Viscoelastic`: any hysteresis model beside a dashpot and a Maxwell element."""

import math
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import number, scales
from ...errors import InputError, shown
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..protocol import Energy, HysteresisModel, State, finite_series
from . import viscoelastic_kernels as kernels
from .wrapper import Wrapper


@dataclass(frozen=True, kw_only=True)
class Viscoelastic(Wrapper):
    """A model beside two elements whose torque depends on the rate.

    T = model(theta) + b dtheta/dt + T_r, with dT_r/dt = k dtheta/dt - T_r / tau: a dashpot, and a
    spring in series with another (a Maxwell element), in parallel with the model. Together with an
    elastic spring these three are the standard linear solid (Findley, Lai and Onaran 1976, chapter
    5). Both elements are passive: in every closed cycle, at any speed, they dissipate energy in
    addition to that of the model. Both are relaxed where a motion begins.

    In an infinitely slow motion both torques vanish. All methods without time assume such a motion:
    `step`, `advance`, `tangent`, `energy`, `inverse`, and `response` without times. The engine
    knows the time: a simulation includes these torques, as does `response` with times, to the first
    order of the time step.

    Attributes:
        model: Hysteretic part, which does not depend on the rate; it may be `Clipped`, `Asymmetric`
            and behind play.
        damping: Damping b of the dashpot [N·m·s/rad].
        relaxation_stiffness: Stiffness k of the Maxwell element [N·m/rad].
        relaxation_time: Time tau in which its torque decays to 1/e [s].
    """

    name = "viscoelastic"
    least: ClassVar = MappingProxyType(
        {"damping": 0.0, "relaxation_stiffness": 0.0, "relaxation_time": 0.0}
    )
    c_state: ClassVar[int] = 2

    damping: float = 0.0
    relaxation_stiffness: float = 0.0
    relaxation_time: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.model, HysteresisModel) or isinstance(self.model, Viscoelastic):
            raise InputError(
                f"model is {shown(self.model)}: give one hysteresis model, not viscoelastic itself"
            )
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
            InputError: See `HysteresisModel.response`; or the times do not ascend, or are not as
                many as the angles.
            PoleError: The motion meets the pole of an uncertified model.
        """
        angle = finite_series("angle", angle, "rad")
        torque = self.model.response(angle, initial_torque)
        return torque if time is None else torque + self.rate_torque(angle, time)

    def rate_torque(self, angle: ArrayLike, time: ArrayLike) -> Array:
        """Computes the torque of both elements along a motion [N·m], shape (n,).

        Args:
            angle: Joint angles [rad], shape (n,).
            time: Time of each, ascending [s], shape (n,).
        """
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
        kernels.follow(self.begun(), time, angle, torque)
        return torque + (self.damping * np.gradient(angle, time) if angle.size > 1 else 0.0)

    def begun(self) -> Array:
        """Returns parameters and memory of both relaxed elements, as the kernels have them."""
        rate = np.zeros(kernels.SIZE)
        given = self.damping, self.relaxation_stiffness, self.relaxation_time
        rate[: kernels.NUMBERS] = given
        return rate

    def start(self, angle: float, torque: float = 0.0) -> State:
        """Begins a motion at `angle` [rad] with a known resistance of the model [N·m]."""
        return self.model.start(angle, torque)

    def step(self, state: State, angle: float) -> tuple[State, float]:
        """Moves on to `angle` [rad], infinitely slowly."""
        return self.model.step(state, angle)

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves many memories on, infinitely slowly; see `HysteresisModel.advance`."""
        return self.model.advance(memories, angle, soon)

    def tangent(self, state: State, direction: float) -> float:
        """Returns the stiffness [N·m/rad] of a slow motion with the sign `direction`."""
        return self.model.tangent(state, direction)

    def energy(self, state: State) -> Energy:
        """Returns the energy that the model has stored and dissipated in slow motions [J]."""
        return self.model.energy(state)

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate of the model, with a larger torque bound.

        Both elements are passive, so `dissipative` stays. The spring of the Maxwell element never
        deflects by more than the range, which bounds its torque; a dashpot has no bound.
        """
        low, high = checked_range(angle_range)
        inner, more = self.model.certificate((low, high)), 0.0
        if self.relaxation_stiffness > 0:
            more = self.relaxation_stiffness * (high - low)
        if self.damping > 0:
            more = math.inf
        return replace(inner, torque_bound=inner.torque_bound + more)

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> "Viscoelastic":
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta."""
        scales(torque=torque, angle=angle)
        return Viscoelastic(
            model=self.model.scaled(torque=torque, angle=angle),
            damping=self.damping * torque / angle,
            relaxation_stiffness=self.relaxation_stiffness * torque / angle,
            relaxation_time=self.relaxation_time,
        )

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: those of the model, and those that are not 0 here."""
        maxwell = 2 if self.relaxation_stiffness > 0 else 0
        return self.model.free_parameters + (self.damping > 0) + maxwell

    @property
    def units(self) -> dict[str, str]:
        """Units of the parameters, by name; a pure number has no entry."""
        return {
            "damping": "N·m·s/rad",
            "relaxation_stiffness": "N·m/rad",
            "relaxation_time": "s",
        }

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; `model_from_dict` gives the model back."""
        return {**super().to_dict(), **{name: getattr(self, name) for name in self.least}}


def without_rate(model: HysteresisModel) -> HysteresisModel:
    """Returns the model beside the dashpot, or the model itself where there is none."""
    return model.model if isinstance(model, Viscoelastic) else model
