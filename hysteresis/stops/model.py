"""Models of springs with sliders in parallel: Prandtl-Ishlinskii, and hinges of their sum."""

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any, ClassVar, Literal

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..protocol import ConfigKey, HysteresisModel, Numbers, read_only
from . import hinged_stops, prandtl_ishlinskii

Operator = Literal["stop", "play"]
KEYS = (
    ConfigKey("stiffness"),
    ConfigKey("rest_angle", optional=True),
    ConfigKey("thresholds", "list"),
    ConfigKey("weights", "list"),
)
UNITS = {"stiffness": "N·m/rad", "thresholds": "rad", "weights": "N·m/rad", "rest_angle": "rad"}


class Stops(HysteresisModel):
    """A spring and springs with sliders in parallel, which `PrandtlIshlinskii` describes."""

    stiffness: float
    thresholds: Numbers
    weights: Numbers
    rest_angle: float

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.weights) != len(self.thresholds):
            raise self._wrong("weights", "give as many numbers as thresholds")
        if np.any(np.diff(self.thresholds, prepend=0.0) <= 0):
            raise self._wrong("thresholds", "give increasing numbers above 0")

    @property
    def memory_size(self) -> int:  # type: ignore[override]
        """How many numbers the memory holds: three, and the play of each stop."""
        return prandtl_ishlinskii.FIRST_PLAY + len(self.thresholds)

    @abstractmethod
    def _starts(self, angle: float) -> tuple[float, float]:
        """Returns the least and the largest torque [N·m] with which a motion can begin."""

    def _begin(self, angle: float, torque: float) -> Array:
        try:  # a motion begins after the shortest first loading that gives this torque
            return super()._begin(angle, torque)
        except InputError:
            low, high = self._starts(angle)
        raise InputError(
            f"initial torque is {torque:.6g} N·m at {angle:.6g} rad: this {self.name} model can "
            f"begin with {low:.6g} to {high:.6g} N·m there; give a torque in between"
        )


@dataclass(frozen=True, kw_only=True)
class PrandtlIshlinskii(Stops):
    """Resistance T of a joint as an elastic part and a weighted sum of elementary loops.

    With u = angle - rest_angle, and stops E_r and plays F_r = u - E_r of thresholds r_i,

        "stop":  T = stiffness u + sum w_i E_i        (the sum softens: springs with sliders)
        "play":  T = stiffness u + sum w_i F_i        (the sum stiffens, with backlash)

    where E_r follows u one to one within its limits |E_r| <= r (Brokate and Sprekels, Hysteresis
    and Phase Transitions, 1996, ch. 2). A stop with w > 0 and a play with w < 0 only ever lose
    energy; other signs are allowed, but the certificate then does not say `dissipative`. A play
    model is the stop model with weights -w and a stiffness larger by sum w, and is computed as
    such. The model has return-point memory, and its loops between the same angles are congruent.

    Attributes:
        stiffness: Stiffness of the elastic part [N·m/rad].
        thresholds: Thresholds r_i [rad], > 0, strictly increasing.
        weights: Weights w_i [N·m/rad], as many as thresholds.
        operator: Which of the two sums the model is.
        rest_angle: Angle at which u is zero [rad].
    """

    name: ClassVar[str] = "prandtl-ishlinskii"
    kernels: ClassVar[ModuleType] = prandtl_ishlinskii
    config_keys: ClassVar[tuple[ConfigKey, ...]] = KEYS
    not_fitted: ClassVar[tuple[str, ...]] = ("thresholds",)
    least: ClassVar[Mapping[str, float]] = {"weights": 0.0}
    units: ClassVar[Mapping[str, str]] = UNITS

    stiffness: float
    thresholds: Numbers
    weights: Numbers
    operator: Operator = "stop"
    rest_angle: float = 0.0

    def __post_init__(self) -> None:
        if self.operator not in ("stop", "play"):
            raise InputError(f"operator is {self.operator!r}: use 'stop' or 'play'")
        super().__post_init__()

    @cached_property
    def loading_slopes(self) -> Array:
        """Slopes [N·m/rad] of the first loading: up to r_1, between the r_i, beyond r_n."""
        steps = np.concatenate([[0.0], np.cumsum(self._arrays[1])])
        return read_only(self.stiffness + (steps if self.operator == "play" else steps[-1] - steps))

    def config(self) -> dict[str, Any]:
        """Returns the parameters as MJCF has them, of the stop form for both operators."""
        sign = 1 if self.operator == "stop" else -1
        weights = (sign * self._arrays[1]).tolist()
        return super().config() | {"stiffness": float(self.loading_slopes[-1]), "weights": weights}

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's; stops keep their strain, up to r_i."""
        own, (thresholds, _) = memory.copy(), self._arrays
        stiffness, rest_angle = self.parameter_vector[: prandtl_ishlinskii.HEADER]
        weights = self.parameter_vector[prandtl_ishlinskii.HEADER + thresholds.size :]
        angle, plays = own[0], own[prandtl_ishlinskii.FIRST_PLAY :]
        plays[:] = np.clip(plays, angle - thresholds, angle + thresholds)
        own[1] = stiffness * (angle - rest_angle) + weights @ (angle - plays)
        return self._keep_loss(own, memory, parameters)

    def _starts(self, angle: float) -> tuple[float, float]:
        elastic = float(self.parameter_vector[0]) * (angle - self.rest_angle)
        stops = self.loading_slopes[:-1] - self.loading_slopes[-1]
        reach = np.abs(np.cumsum(stops * np.diff(self._arrays[0], prepend=0.0))).max()
        return elastic - reach, elastic + reach

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate for every motion, from every start.

        In the stop form |E_i| <= r_i, and there is no pole. A cycle loses the integral of
        sum w_i r_i |dF_i|, which is never negative if no w_i is negative.
        """
        low, high = checked_range(angle_range)
        stiffness, weights = self.parameter_vector[0], self.parameter_vector[-len(self.weights) :]
        memory_bound = float(np.abs(weights) @ self._arrays[0])
        reach = max(abs(low - self.rest_angle), abs(high - self.rest_angle))
        return Certificate(
            margin=1.0,
            dissipative=bool(np.all(weights >= 0)),
            torque_bound=memory_bound + (abs(float(stiffness)) * reach if stiffness else 0.0),
            memory_bound=memory_bound,
            angle_range=(low, high),
        )

    @cached_property
    def _arrays(self) -> tuple[Array, Array]:
        return read_only(self.thresholds), read_only(self.weights)


@dataclass(frozen=True, kw_only=True)
class HingedStops(Stops):
    """Resistance T of a joint as a rising function of a Prandtl-Ishlinskii model of stops.

    With u = angle - rest_angle, and stops E_r of thresholds r_i as in `PrandtlIshlinskii`,

        P = stiffness u + sum w_i E_i
        T = offset + h(P)

    where h is piecewise linear, h(0) = 0, with the slopes s_0 below the knot d_1, s_1 from d_1 to
    d_2, and so on. So T need not be odd, and may also stiffen, unlike P. Dead zones around a
    Prandtl-Ishlinskii model are the case of rising slopes (Kuhnen, Eur. J. Control 9, 2003, 407,
    "modified Prandtl-Ishlinskii"). The model has return-point memory.

    Every such model is certified and dissipative. Let `stored` be offset u and the work that a
    monotone unloading from the present state gives back until P = 0. Unloading lowers `stored` by
    exactly that work. Loading by du takes the work (offset + h) du; at each angle the unloading
    path from the new state is nowhere above the loading path and the unloading path from the old
    state, because a stop that returns from a farther angle is nowhere less unloaded; and h keeps
    that order. So `stored` rises by no more than the work, and no closed cycle gives energy back.
    The path reaches P = 0: without stiffness the path ends where all stops slip the other way.

    Attributes:
        stiffness: Stiffness of the spring beside the stops, in P [N·m/rad], >= 0.
        thresholds: Thresholds r_i [rad], > 0, strictly increasing.
        weights: Weights w_i, in P [N·m/rad], >= 0, as many as thresholds.
        knots: Knots d_k of h, in P [N·m], strictly increasing, 1 to 16.
        slopes: Slopes of h below, between and above the knots, >= 0, one more than knots.
        offset: Resistance where P = 0 [N·m].
        rest_angle: Angle at which u is zero [rad].
    """

    name: ClassVar[str] = "hinged-stops"
    kernels: ClassVar[ModuleType] = hinged_stops
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (
        *KEYS,
        ConfigKey("knots", "list"),
        ConfigKey("slopes", "list"),
        ConfigKey("offset", optional=True),
    )
    not_fitted: ClassVar[tuple[str, ...]] = ("thresholds", "knots")
    least: ClassVar[Mapping[str, float]] = {"weights": 0.0, "slopes": 0.0}
    units: ClassVar[Mapping[str, str]] = {**UNITS, "knots": "N·m", "offset": "N·m"}

    stiffness: float
    thresholds: Numbers
    weights: Numbers
    knots: Numbers
    slopes: Numbers
    offset: float = 0.0
    rest_angle: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        most = hinged_stops.MOST_KNOTS
        if len(self.knots) > most or np.any(np.diff(self.knots) <= 0):
            raise self._wrong("knots", f"give 1 to {most} increasing numbers")
        if len(self.slopes) != len(self.knots) + 1:
            raise self._wrong("slopes", "give one number more than knots")
        for name in ("stiffness", "weights", "slopes"):
            if np.min(getattr(self, name)) < 0:
                raise self._wrong(name, "give numbers of at least 0")

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters as the kernels read them: those of stops, the offset, and h.

        The values at the knots follow from h(0) = 0, outwards from the piece around 0.
        """
        knots, slopes, m, most = self.knots, self.slopes, len(self.knots), hinged_stops.MOST_KNOTS
        zero = sum(knot <= 0 for knot in knots)
        values = [0.0] * m
        for k in range(zero, m):
            below, value = (knots[k - 1], values[k - 1]) if k > zero else (0.0, 0.0)
            values[k] = value + slopes[k] * (knots[k] - below)
        for k in reversed(range(zero)):
            above, value = (knots[k + 1], values[k + 1]) if k < zero - 1 else (0.0, 0.0)
            values[k] = value - slopes[k + 1] * (above - knots[k])
        room = [0.0] * (most - m)
        hinge = [self.offset, m, *knots, *room, *values, *room, *slopes, *room]
        return read_only([*self.stops.parameter_vector, *hinge])

    @cached_property
    def stops(self) -> PrandtlIshlinskii:
        """The model of stops whose torque is P."""
        return PrandtlIshlinskii(
            stiffness=self.stiffness,
            thresholds=self.thresholds,
            weights=self.weights,
            rest_angle=self.rest_angle,
        )

    def hinge(self, P: float) -> float:
        """Returns h(P) [N·m]."""
        return float(hinged_stops.hinged(self._parameters[-hinged_stops.HINGE :], float(P)))

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: stiffness, weights, slopes and offset less one scale.

        Thresholds, knots and rest angle are given.
        """
        return 1 + len(self.weights) + len(self.slopes)

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's; stops keep their strain, up to r_i."""
        own = self.stops.carry_over(memory, parameters)
        own[1] = self.offset + self.hinge(own[1])
        return own

    def _starts(self, angle: float) -> tuple[float, float]:
        return self._torques(angle, angle)

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate for every motion, from every start.

        There is no pole, and the docstring of the class proves that no cycle gives energy back.
        |E_i| <= r_i bounds P, and h rises, so T is bounded by the values at both ends.
        """
        low, high = checked_range(angle_range)
        return Certificate(
            margin=1.0,
            dissipative=True,
            torque_bound=max(map(abs, self._torques(low, high))),
            memory_bound=max(self.slopes) * self._reach,
            angle_range=(low, high),
        )

    @cached_property
    def _reach(self) -> float:
        """The largest |sum w_i E_i| [N·m]."""
        return float(np.dot(self.weights, self.thresholds))

    def _torques(self, low: float, high: float) -> tuple[float, float]:
        """Returns the least and the largest T [N·m] between two angles [rad], maybe infinite."""
        ends = []
        for angle, reach, slope in ((low, -self._reach, 0), (high, self._reach, -1)):
            P = reach + (self.stiffness * (angle - self.rest_angle) if self.stiffness else 0.0)
            if math.isinf(P):  # h is infinite too, unless the outermost slope is 0
                P = P if self.slopes[slope] else self.knots[min(slope, 0)]
            ends.append(self.offset + (P if math.isinf(P) else self.hinge(P)))
        return ends[0], ends[1]
