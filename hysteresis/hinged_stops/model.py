"""Hinged stops: springs with sliders in parallel, behind a hinge function of their sum."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from types import ModuleType
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array
from ...checks import number, numbers, scales
from ...errors import InputError
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..config import ConfigKey
from ..prandtl_ishlinskii.model import PrandtlIshlinskii
from ..protocol import HysteresisModel, Numbers, State, read_only
from . import kernels


@dataclass(frozen=True, kw_only=True)
class HingedStops(HysteresisModel):
    """Resistance T of a joint as a rising function of a Prandtl-Ishlinskii model of stops.

    With u = angle - rest_angle, and stops E_r of thresholds r_i as in `PrandtlIshlinskii`,

        P = stiffness u + sum w_i E_i
        T = offset + h(P)

    where h is piecewise linear, h(0) = 0, with the slopes s_0 below the knot d_1, s_1 from d_1 to
    d_2, and so on. So T need not be odd, and may also stiffen, unlike P. Dead zones around a
    Prandtl-Ishlinskii model are the case of rising slopes (Kuhnen, Eur. J. Control 9, 2003, 407,
    "modified Prandtl-Ishlinskii"). The model has return-point memory.

    Every such model is certified and dissipative. Let `stored` be offset u and the work that a
    monotone unloading from the present state gives back until P = 0. Unloading lowers it by exactly
    the work that comes back. Loading by du takes the work (offset + h) du; the unloading path from
    the new state is, at the same angle, nowhere beyond the loading path and the unloading path from
    the old state, because a stop that comes back from further on is nowhere less unloaded; and h
    keeps that order. So `stored` rises by no more than the work, and no closed cycle gives energy
    back. The path does reach P = 0: without stiffness it ends where all stops slip the other way.

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
    kernels: ClassVar[ModuleType] = kernels
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (
        ConfigKey("stiffness"),
        ConfigKey("rest_angle", optional=True),
        ConfigKey("thresholds", "list"),
        ConfigKey("weights", "list"),
        ConfigKey("knots", "list"),
        ConfigKey("slopes", "list"),
        ConfigKey("offset", optional=True),
    )
    not_fitted: ClassVar[tuple[str, ...]] = ("thresholds", "knots")
    least: ClassVar[Mapping[str, float]] = {"weights": 0.0, "slopes": 0.0}

    stiffness: float
    thresholds: Numbers
    weights: Numbers
    knots: Numbers
    slopes: Numbers
    offset: float = 0.0
    rest_angle: float = 0.0

    def __post_init__(self) -> None:
        stops = PrandtlIshlinskii(
            stiffness=self.stiffness,
            thresholds=self.thresholds,
            weights=self.weights,
            rest_angle=self.rest_angle,
        )
        for name in ("stiffness", "thresholds", "weights", "rest_angle"):
            object.__setattr__(self, name, getattr(stops, name))
        object.__setattr__(self, "offset", number("offset", self.offset, "N·m"))
        for name, unit in (("knots", "N·m"), ("slopes", "")):
            object.__setattr__(self, name, numbers(name, getattr(self, name), unit))
        signed = {"stiffness": self.stiffness}
        signed |= {f"weights[{i}]": weight for i, weight in enumerate(self.weights)}
        signed |= {f"slopes[{k}]": slope for k, slope in enumerate(self.slopes)}
        for name, value in signed.items():
            if value < 0:
                raise InputError(
                    f"{name} is {value}: it must be at least 0, or the model would drive the joint"
                )
        if len(self.knots) > kernels.MOST_KNOTS:
            raise InputError(
                f"there are {len(self.knots)} knots: give at most {kernels.MOST_KNOTS}"
            )
        if len(self.slopes) != len(self.knots) + 1:
            raise InputError(
                f"there are {len(self.slopes)} slopes for {len(self.knots)} knots: give one slope "
                "below the first knot and one above each"
            )
        for k, (below, here) in enumerate(pairwise(self.knots), 1):
            if not here > below:
                raise InputError(
                    f"knots[{k}] is {here} N·m: it must be above {below}; give knots in increasing "
                    "order"
                )

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
        return float(kernels.hinged(self._parameters[-kernels.HINGE :], float(P)))

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters as the kernels read them, with room for more knots; read-only."""
        p = np.empty(kernels.HEADER + kernels.HINGE + 2 * len(self.thresholds))
        rows = (self.thresholds, self.weights, self.knots, self.slopes)
        thresholds, weights, knots, slopes = map(np.array, rows)
        kernels.set_parameters(
            p, self.stiffness, self.rest_angle, thresholds, weights, self.offset, knots, slopes
        )
        return read_only(p)

    @property
    def memory_size(self) -> int:
        """How many numbers the memory holds: angle, torque, loss and the play of each stop."""
        return kernels.FIRST_PLAY + len(self.thresholds)

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: stiffness, weights, slopes and offset less one scale.

        Thresholds, knots and rest angle are given.
        """
        return 1 + len(self.weights) + len(self.slopes)

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory in place of another model's; stops keep their strain, up to r_i."""
        own = self.stops.carry_over(memory, parameters)
        own[1] = self.offset + self.hinge(own[1])
        return own

    def start(self, angle: float, torque: float = 0.0) -> State:
        """Begins a motion at `angle` [rad] with a known resistance [N·m].

        The stops are as after a first loading, the shortest one that gives this torque.
        """
        number("angle", angle, "rad")
        number("initial torque", torque, "N·m")
        try:
            return super().start(angle, torque)
        except InputError:
            pass
        low, high = self._torques(angle, angle)
        raise InputError(
            f"initial torque is {torque:.6g} N·m at {angle:.6g} rad: this {self.name} model can "
            f"begin with {low:.6g} to {high:.6g} N·m there; give a torque in between"
        )

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """States what holds for every motion, from every start.

        Nothing has a pole, and the docstring of the class proves that no cycle gives energy back.
        |E_i| <= r_i bounds P, and h rises, so that T is bounded by its values at the ends.
        """
        low, high = checked_range(angle_range)
        return Certificate(
            margin=1.0,
            dissipative=True,
            torque_bound=max(map(abs, self._torques(low, high))),
            memory_bound=max(self.slopes) * self._reach,
            angle_range=(low, high),
        )

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> "HingedStops":
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta.

        Args:
            torque: Scale of the resistance, > 0.
            angle: Scale of the angles, > 0.
        """
        scales(torque=torque, angle=angle)
        return replace(
            self,
            stiffness=self.stiffness * torque / angle,
            thresholds=[r * angle for r in self.thresholds],
            weights=[w * torque / angle for w in self.weights],
            knots=[d * torque for d in self.knots],
            offset=self.offset * torque,
            rest_angle=self.rest_angle * angle,
        )

    @property
    def units(self) -> dict[str, str]:
        """Units of the parameters, by name; a pure number has no entry."""
        return {
            "stiffness": "N·m/rad",
            "thresholds": "rad",
            "weights": "N·m/rad",
            "knots": "N·m",
            "offset": "N·m",
            "rest_angle": "rad",
        }

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; `model_from_dict` gives the model back."""
        return {
            "model": self.name,
            "stiffness": self.stiffness,
            "thresholds": list(self.thresholds),
            "weights": list(self.weights),
            "knots": list(self.knots),
            "slopes": list(self.slopes),
            "offset": self.offset,
            "rest_angle": self.rest_angle,
        }

    @cached_property
    def _reach(self) -> float:
        """The largest |sum w_i E_i| [N·m]."""
        return float(np.dot(self.weights, self.thresholds))

    def _torques(self, low: float, high: float) -> tuple[float, float]:
        """Returns the least and the largest T [N·m] between two angles [rad], maybe infinite."""
        ends = []
        for angle, reach, slope in ((low, -self._reach, 0), (high, self._reach, -1)):
            P = reach + (self.stiffness * (angle - self.rest_angle) if self.stiffness else 0.0)
            if math.isinf(P):  # what h is there depends on the outermost slope
                P = P if self.slopes[slope] else self.knots[min(slope, 0)]
            ends.append(self.offset + (P if math.isinf(P) else self.hinge(P)))
        return ends[0], ends[1]
