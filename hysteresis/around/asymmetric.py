"""`Asymmetric`: any hysteresis model plus an elastic polynomial of the angle."""

from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import Any

import numpy as np
from numpy.polynomial import polynomial as poly
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import number, scales
from ...errors import InputError, shown
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..polynomial import UNIT, coefficients, extremes, rescaled
from ..protocol import Energy, HysteresisModel, Numbers, State, finite_series
from .clipped import Clipped
from .wrapper import Wrapper


@dataclass(frozen=True, kw_only=True)
class Asymmetric(Wrapper):
    """A model plus a history-independent torque: T = model(theta) + sum p_i theta^i.

    Measured loops of suit joints are not symmetric (Li et al. 2022, section 5.2), but the loops of
    most models are. The polynomial bends the loop and leaves the dissipated energy as it is,
    because its own work depends on the first and last angle only.

    Attributes:
        model: Hysteretic part, any model that is not asymmetric itself.
        polynomial: Coefficients p_0, p_1, ..., at most six [N·m/rad^i].

    Raises:
        InputError: The polynomial is not finite or too long, or the model is asymmetric itself.
    """

    name = "asymmetric"

    polynomial: Numbers

    def __post_init__(self) -> None:
        wrapped = isinstance(self.model, Wrapper) and not isinstance(self.model, Clipped)
        if not isinstance(self.model, HysteresisModel) or wrapped:
            raise InputError(
                f"model is {shown(self.model)}: give one hysteresis model, bare or `Clipped`"
            )
        object.__setattr__(self, "polynomial", coefficients("polynomial", self.polynomial))

    def elastic(self, angle: ArrayLike) -> Array:
        """Returns the torque [N·m] of the polynomial at angles [rad]."""
        angles = np.asarray(angle, dtype=np.float64)
        return np.asarray(poly.polyval(angles, np.array(self.polynomial)), dtype=np.float64)

    def response(self, angle: ArrayLike, initial_torque: float = 0.0) -> Array:
        """Computes the resistance along a sequence of angles; see `HysteresisModel.response`."""
        angle = finite_series("angle", angle, "rad")
        number("initial torque", initial_torque, "N·m")
        elastic = self.elastic(angle)
        torque = self.model.response(angle, initial_torque - elastic[0]) + elastic
        torque[0] = initial_torque
        return torque

    def start(self, angle: float, torque: float = 0.0) -> State:
        """Begins a motion at `angle` [rad] with a known resistance [N·m]."""
        number("angle", angle, "rad")
        number("initial torque", torque, "N·m")
        inner = self.model.start(angle, torque - float(self.elastic(angle)))
        return replace(inner, torque=float(torque))

    def step(self, state: State, angle: float) -> tuple[State, float]:
        """Moves on to `angle` [rad]; steps give the same torques as `response`, bit for bit."""
        inner, torque = self.model.step(state, angle)
        torque += float(self.elastic(angle))
        if angle == state.angle:
            torque = state.torque
        return replace(inner, torque=torque), torque

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves many memories on, in place; see `HysteresisModel.advance`."""
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

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> "Asymmetric":
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta."""
        scales(torque=torque, angle=angle)
        return Asymmetric(
            model=self.model.scaled(torque=torque, angle=angle),
            polynomial=rescaled(self.polynomial, torque, angle),
        )

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: those of the inner model and the coefficients."""
        return self.model.free_parameters + len(self.polynomial)

    @property
    def units(self) -> dict[str, str]:
        """Units of the parameters, by name; a pure number has no entry."""
        return {"polynomial": UNIT}

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; `model_from_dict` gives the model back."""
        return {**super().to_dict(), "polynomial": list(self.polynomial)}


def sprung(model: HysteresisModel, offset: float, stiffness: float) -> HysteresisModel:
    """Returns the model plus a straight elastic line, which dissipates nothing.

    Args:
        model: Any hysteresis model; an asymmetric one gets the line added to its polynomial, also
            where it is behind play or the part of a viscoelastic one.
        offset: Torque of the line at angle 0 [N·m].
        stiffness: Its slope [N·m/rad].
    """
    line = [offset, stiffness]
    if isinstance(model, Wrapper) and not isinstance(model, Asymmetric | Clipped):
        return replace(model, model=sprung(model.model, offset, stiffness))
    if not isinstance(model, Asymmetric):
        return Asymmetric(model=model, polynomial=line)
    terms = zip_longest(model.polynomial, line, fillvalue=0.0)
    return Asymmetric(model=model.model, polynomial=[float(p) + q for p, q in terms])
