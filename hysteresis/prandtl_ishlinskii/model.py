"""The Prandtl-Ishlinskii model: springs with sliders in parallel, and the inverse of their sum."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from types import ModuleType
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import number, numbers, scales
from ...errors import InputError
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..config import ConfigKey
from ..protocol import HysteresisModel, Numbers, State, finite_series, read_only
from . import kernels

Operator = Literal["stop", "play"]


@dataclass(frozen=True, kw_only=True)
class PrandtlIshlinskii(HysteresisModel):
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
    kernels: ClassVar[ModuleType] = kernels
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (
        ConfigKey("stiffness"),
        ConfigKey("rest_angle", optional=True),
        ConfigKey("thresholds", "list"),
        ConfigKey("weights", "list"),
    )
    not_fitted: ClassVar[tuple[str, ...]] = ("thresholds",)
    least: ClassVar[Mapping[str, float]] = {"weights": 0.0}

    stiffness: float
    thresholds: Numbers
    weights: Numbers
    operator: Operator = "stop"
    rest_angle: float = 0.0

    def __post_init__(self) -> None:
        if self.operator not in ("stop", "play"):
            raise InputError(f"operator is {self.operator!r}: use 'stop' or 'play'")
        for name, unit in (("stiffness", "N·m/rad"), ("rest_angle", "rad")):
            object.__setattr__(self, name, number(name, getattr(self, name), unit))
        for name, unit in (("thresholds", "rad"), ("weights", "N·m/rad")):
            object.__setattr__(self, name, numbers(name, getattr(self, name), unit))
        if len(self.weights) != len(self.thresholds):
            raise InputError(
                f"there are {len(self.weights)} weights for {len(self.thresholds)} thresholds: "
                "give one weight for each threshold"
            )
        for i, (below, here) in enumerate(pairwise((0.0, *self.thresholds))):
            if not here > below:
                raise InputError(
                    f"thresholds[{i}] is {here} rad: it must be above {below}; give positive "
                    "thresholds in increasing order"
                )

    @cached_property
    def loading_slopes(self) -> Array:
        """Slopes [N·m/rad] of the first loading: up to r_1, between the r_i, beyond r_n."""
        steps = np.concatenate([[0.0], np.cumsum(self._arrays[1])])
        return read_only(self.stiffness + (steps if self.operator == "play" else steps[-1] - steps))

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters of the stop form: stiffness, rest_angle, thresholds, weights."""
        thresholds, weights = self._arrays
        sign = 1 if self.operator == "stop" else -1
        return read_only([self.loading_slopes[-1], self.rest_angle, *thresholds, *(sign * weights)])

    @property
    def memory_size(self) -> int:
        """How many numbers the memory holds: angle, torque, loss and the play of each element."""
        return 3 + len(self.thresholds)

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit chooses: weights, stiffness and rest angle, not the thresholds."""
        return 2 + len(self.weights)

    def config(self) -> dict[str, Any]:
        """Returns the parameters as MJCF has them: those of stops, whatever the operator."""
        stiffness, rest_angle, *rows = self.parameter_vector.tolist()
        count = len(self.thresholds)
        return {
            "stiffness": stiffness,
            "rest_angle": rest_angle,
            "thresholds": rows[:count],
            "weights": rows[count:],
        }

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory in place of another model's; stops keep their strain, up to r_i."""
        own, (thresholds, _) = memory.copy(), self._arrays
        stiffness, rest_angle = self.parameter_vector[: kernels.HEADER]
        weights = self.parameter_vector[kernels.HEADER + thresholds.size :]
        angle, plays = own[0], own[kernels.FIRST_PLAY :]
        plays[:] = np.clip(plays, angle - thresholds, angle + thresholds)
        own[1] = stiffness * (angle - rest_angle) + weights @ (angle - plays)
        return self._keep_loss(own, memory, parameters)

    def start(self, angle: float, torque: float = 0.0) -> State:
        """Begins a motion at `angle` [rad] with a known resistance [N·m].

        The elements are as after a first loading, the shortest one that gives this torque.
        """
        number("angle", angle, "rad")
        number("initial torque", torque, "N·m")
        try:
            return super().start(angle, torque)
        except InputError:
            pass
        elastic = float(self.parameter_vector[0]) * (angle - self.rest_angle)
        stops = self.loading_slopes[:-1] - self.loading_slopes[-1]
        reach = np.abs(np.cumsum(stops * np.diff(self._arrays[0], prepend=0.0))).max()
        raise InputError(
            f"initial torque is {torque:.6g} N·m at {angle:.6g} rad: this {self.name} model can "
            f"begin with {elastic - reach:.6g} to {elastic + reach:.6g} N·m there; give a torque "
            "in between"
        )

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """States what holds for every motion, from every start.

        In the stop form |E_i| <= r_i, and nothing has a pole. A cycle loses the integral of
        sum w_i r_i |dF_i|, which is never negative if no w_i is.
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

    def inverse(self, torque: ArrayLike, initial_angle: float = 0.0) -> Array:
        """Computes the angles along which the resistance follows given torques, exactly.

        The inverse of a rising Prandtl-Ishlinskii model is one again (Kuhnen, Eur. J. Control 9,
        2003, 407): its plays have the thresholds psi(r_i), psi the first loading curve, and the
        slopes of its loading curve are the reciprocals. It is explicit and O(n) per sample.

        Args:
            torque: Resistance [N·m], shape (n,).
            initial_angle: Angle of torque[0] [rad].

        Returns:
            Angles [rad], shape (n,), with angle[0] == initial_angle; `response` gives the torques
            back.

        Raises:
            InputError: `torque` is not one finite series, the model has no such start, or it does
                not rise everywhere: it saturates, or its slope falls below zero.
        """
        torque = finite_series("torque", torque, "N·m")
        thresholds, slopes = self._arrays[0], self.loading_slopes
        if not np.all(slopes > 0):
            bad = int(np.flatnonzero(~(slopes > 0))[0])
            raise InputError(
                f"the first loading has the slope {slopes[bad]:.6g} N·m/rad beyond "
                f"{[0.0, *thresholds][bad]:.6g} rad: an inverse needs slopes above 0 everywhere; "
                f"raise the stiffness by more than {0.0 - slopes.min():.6g} N·m/rad"
            )
        state = self.start(initial_angle, torque[0])
        # The start is the first loading by x from the angle where all stops were at zero. The
        # inverse gets there by its own first loading, from the torque that was there.
        x = state.angle - state.memory[-1]
        psi = np.cumsum(slopes[:-1] * np.diff(thresholds, prepend=0.0))
        loaded = np.interp(abs(x), [0.0, *thresholds], [0.0, *psi])
        plays = np.copysign(np.maximum(loaded - psi, 0.0), x)
        origin = torque[0] - math.copysign(loaded, x)
        angle = np.empty_like(torque)
        weights = np.diff(1 / slopes)
        self.kernels.play_sum(1 / slopes[0], psi, weights, plays, torque - origin, angle)
        angle += state.angle - x
        angle[0] = state.angle
        return angle

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> "PrandtlIshlinskii":
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
            rest_angle=self.rest_angle * angle,
        )

    @property
    def units(self) -> dict[str, str]:
        """Units of the parameters, by name; a pure number has no entry."""
        stiffness = "N·m/rad"
        return {
            "stiffness": stiffness,
            "thresholds": "rad",
            "weights": stiffness,
            "rest_angle": "rad",
        }

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; `model_from_dict` gives the model back."""
        return {
            "model": self.name,
            "stiffness": self.stiffness,
            "thresholds": list(self.thresholds),
            "weights": list(self.weights),
            "operator": self.operator,
            "rest_angle": self.rest_angle,
        }

    @cached_property
    def _arrays(self) -> tuple[Array, Array]:
        return read_only(self.thresholds), read_only(self.weights)
