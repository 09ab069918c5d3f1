"""The parameters of fits: name, unit, value and limits, and the constraints of the user."""

import copy
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import lsq_linear

from ...arrays import Array
from ...checks import number
from ...errors import InputError, shown, unknown_name
from ...hysteresis.around import Backlash, Viscoelastic
from ...hysteresis.bouc_wen.kernels import LARGEST_POWER
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ...hysteresis.protocol import HysteresisModel, Numbers
from ...hysteresis.registry import MODELS, model_from_dict

Path = tuple[str | int, ...]
Ends = tuple[float, float]
EVERY: Ends = (-math.inf, math.inf)
NEAR = 1e-3  # relative distance from a bound up to which a parameter counts as at the bound
INSIDE = 1e-3  # share of a bound where a search begins if its usual box lies beyond the bound
# Parameters that may equal their least value; all others are above theirs.
REACHED = ("n", "gap", "damping", "relaxation_stiffness", "relaxation_time")
LEAST_C = {"certified": {"c": 1.0}, "magnetic": {"c": 0.0}}  # by method
MOST = {"n": LARGEST_POWER, "magnetic c": 0.999}


@dataclass(frozen=True)
class Constraints:
    """Parameters that the user fixes or bounds, by name, in the units of the fitted model.

    A name without an index, such as weights, means every number of that list. An infinite bound
    leaves its side open.
    """

    fixed: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, Ends] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, given in (("fixed", self.fixed), ("bounds", self.bounds)):
            if not isinstance(given, Mapping):
                raise InputError(f"{name} is {shown(given)}: give a dictionary by parameter name")
        for name, value in self.fixed.items():
            number(f"fixed {name}", value)
        for name, pair in self.bounds.items():
            try:
                low, high = (float(end) for end in ([] if isinstance(pair, str) else pair))
            except (TypeError, ValueError):
                low = high = math.nan
            if not low < high:
                raise InputError(
                    f"bounds of {name} are {shown(pair)}: give two numbers (low, high), low < high"
                )
            if name in self.fixed:
                raise InputError(
                    f"{name} is fixed at {self.fixed[name]:g} and bounded by {shown(pair)}: give "
                    "one of them"
                )

    def __bool__(self) -> bool:
        return bool(self.fixed or self.bounds)

    @property
    def names(self) -> list[str]:
        """Names of all constrained parameters."""
        return [*self.fixed, *self.bounds]

    def has(self, *names: str) -> bool:
        """Returns whether any of some parameters is fixed or bounded."""
        return any(self.ends(name) != EVERY for name in names)

    def hold(self, model: HysteresisModel) -> bool:
        """Returns whether a fitted model obeys the constraints on its own parameters."""
        every = parameters_of(model, self)
        self.ends_of([one.name for one in every])  # refuses an index that the model does not have
        return all(one.low <= one.value <= one.high for one in every)

    def ends(self, name: str) -> Ends:
        """Returns the lowest and highest allowed value of a number, such as c or weights[3]."""
        for known in (name, name.partition("[")[0]):
            if known in self.fixed:
                return float(self.fixed[known]), float(self.fixed[known])
            if known in self.bounds:
                low, high = self.bounds[known]
                return float(low), float(high)
        return EVERY

    def ends_of(self, names: Sequence[str]) -> Array:
        """Returns lower and upper bounds of all numbers of a model, shape (2, n)."""
        bases = [name.partition("[")[0] for name in names]
        for name in self.names:
            if name.partition("[")[0] in bases and name not in (*names, *bases):
                like = [one for one in names if one.startswith(name.partition("[")[0])]
                raise InputError(
                    f"there is no {name}: the model has {like[0]} to {like[-1]}; name one of them"
                )
        return np.array([self.ends(name) for name in names]).T

    def box(self, name: str, usual: Ends, least: float = -math.inf) -> Ends:
        """Returns the search box of a parameter: the user's bounds in place of the usual ends.

        The search cannot reach `least`; a bound there leaves the usual end.
        """
        given_low, given_high = self.ends(name)
        low = given_low if given_low > least and given_low > -math.inf else usual[0]
        high = given_high if given_high < math.inf else usual[1]
        if low > high and given_low == low:  # the usual box lies below the user's bounds
            high = low + (abs(low) or 1.0) / INSIDE
        elif low > high:
            low = (
                least + INSIDE * (high - least) if least > -math.inf else high - abs(high) / INSIDE
            )
        return low, high

    def check(self, kind: str, beside: Mapping[str, str], method: str = "certified") -> None:
        """Refuses parameters that a kind of model does not have, and values out of their range.

        `beside` has the rate and play that are fitted beside the model, if any.
        """
        if not self:
            return
        known = parameter_limits(kind, beside, method)
        for name in self.names:
            base, bracket, _ = name.partition("[")
            if base not in known or (bracket and not known[base].is_list):
                raise unknown_name(f"parameter of {kind!r}", name, known)
            if not known[base].allows(*self.ends(name)):
                text = " to ".join(f"{end:g}" for end in dict.fromkeys(self.ends(name)))
                raise InputError(
                    f"{name} is {text}: a fit of {kind!r} allows numbers {known[base]}; its "
                    f"parameters are {', '.join(known)}"
                )
        if self.fixed.keys() >= known.keys():
            raise InputError(
                f"every parameter of {kind!r} is fixed, and nothing is left to fit: leave one of "
                f"{', '.join(known)} free"
            )


FREE = Constraints()


class Limits(NamedTuple):
    """The range of a parameter of some model."""

    least: float
    most: float
    is_closed: bool  # whether the least number itself is allowed
    is_list: bool  # whether the parameter is a list of such numbers

    def __str__(self) -> str:
        upper = f" to {self.most:g}" if self.most < math.inf else ""
        return f"{'from' if self.is_closed else 'above'} {self.least:g}{upper}"

    def allows(self, low: float, high: float) -> bool:
        """Returns whether a parameter can have these bounds, of which each may be infinite."""
        if low == high:
            return self.least < low <= self.most or (self.is_closed and low == self.least)
        begins = low == -math.inf or self.least <= low < self.most
        return begins and (high == math.inf or self.least < high <= self.most)


def parameter_limits(kind: str, beside: Mapping[str, str], method: str) -> dict[str, Limits]:
    """Returns the parameters that a fit of a model has, by name; see `Constraints.check`."""
    kinds = [MODELS[kind]] if kind in MODELS else []
    kinds += [JilesAtherton] if kind == "asymmetric" else []
    kinds += [Backlash] if "play" in beside else []
    kinds += [Viscoelastic] if "rate" in beside else []
    found: dict[str, Limits] = {}
    for model in kinds:
        least: Any = model.least
        if model is JilesAtherton:  # whose limits depend on c
            least = {"Ms": 0.0, "a": 0.0, "k": 0.0} | LEAST_C.get(method, {})
        for one in fields(cast(Any, model)):
            is_list = one.type in (Numbers, Sequence[Numbers])
            if (is_list or one.type is float) and one.name not in model.not_fitted:
                is_closed = is_list or one.name in REACHED
                most = MOST.get(one.name, MOST.get(f"{method} {one.name}", math.inf))
                ends = least.get(one.name, -math.inf), most
                found[one.name] = Limits(*ends, is_closed, is_list)
    if beside.get("rate") == "viscous":
        found = {name: one for name, one in found.items() if "relaxation" not in name}
    return found


class Parameter(NamedTuple):
    """One parameter of a fitted model."""

    name: str  # a number in a list has its index: weights[3]
    unit: str  # empty for a pure number
    value: float
    least: float  # least value of such models; -inf without one
    low: float  # lower bound of the user; -inf without one
    high: float  # upper bound of the user; equal to the lower one for a fixed parameter
    path: Path  # keys of the value in the dictionary of the model

    @property
    def state(self) -> str:
        """One of "free", "fixed" and "at its bound"."""
        if self.low == self.high:
            return "fixed"
        finite = [end for end in (self.low, self.high) if math.isfinite(end)]
        near = [NEAR * min(abs(end) or math.inf, self.high - self.low) for end in finite]
        gaps = [abs(self.value - end) for end in finite]
        is_there = any(gap <= least for gap, least in zip(gaps, near, strict=True))
        return "at its bound" if is_there else "free"


def parameters_of(model: HysteresisModel, constraints: Constraints = FREE) -> tuple[Parameter, ...]:
    """Returns all parameters that a fit of a model chooses, or that the user fixed."""
    return tuple(_parameters((), model.to_dict(), constraints))


def _parameters(path: Path, content: Any, constraints: Constraints) -> Iterator[Parameter]:
    model = model_from_dict(content)
    for key, value in content.items():
        if key in model.not_fitted:
            continue
        if isinstance(value, dict):
            yield from _parameters((*path, key), value, constraints)
            continue
        least, unit = model.least.get(key, -math.inf), model.units.get(key, "")
        for place, name, one in numbers_in((*path, key), key, value):
            yield Parameter(name, unit, one, least, *constraints.ends(name), place)


def numbers_in(path: Path, name: str, value: Any) -> Iterator[tuple[Path, str, float]]:
    """Yields path, name and value of all numbers in a value; in a list the name has the index."""
    if isinstance(value, Mapping):
        for key, one in value.items():
            yield from numbers_in((*path, key), key, one)
    elif isinstance(value, list | tuple):
        for i, one in enumerate(value):
            yield from numbers_in((*path, i), f"{name}[{i}]", one)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, name, float(value)


def with_values(content: dict[str, Any], values: Mapping[Path, float]) -> HysteresisModel:
    """Returns the model of a dictionary with other numbers in some places."""
    content = copy.deepcopy(content)
    for path, value in values.items():
        place: Any = content
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value
    return model_from_dict(content)


def bounded_least_squares(
    columns: ArrayLike, target: Array, low: ArrayLike, high: ArrayLike
) -> tuple[Array, float]:
    """Returns the x (n,) with the least |columns x - target| and low <= x <= high, and that norm.

    Columns have the shape (rows, n), the target (rows,). A number with equal bounds is fixed.
    """
    columns, low, high = (np.asarray(one, dtype=np.float64) for one in (columns, low, high))
    x, free = low.copy(), low < high
    if free.any():
        size = np.linalg.norm(columns[:, free], axis=0)
        size[size == 0] = 1.0
        rest = target - columns[:, ~free] @ low[~free]
        ends = low[free] * size, high[free] * size
        found = lsq_linear(columns[:, free] / size, rest, ends, method="bvls", tol=1e-12)
        x[free] = np.clip(found.x / size, low[free], high[free])
    return x, float(np.linalg.norm(columns @ x - target))
