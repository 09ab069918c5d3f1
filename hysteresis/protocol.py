"""`HysteresisModel`, the protocol of every hysteresis model over its compiled kernels.

The torque depends on the order of the angles, not on time or on the number of samples: `step` gives
the torques of `response` to the last bit, and so does the engine.

    model = BoucWen(elastic=3, hysteretic=9, beta=4, gamma=1, n=1.5)
    torque = model.response([0.0, 0.8, 0.3])  # N·m at angles in rad, from 0 N·m on
    state = model.start(0.0)
    for angle in (0.8, 0.3):
        state, last = model.step(state, angle)  # last == torque[1], then torque[2]
    lost = model.energy(state).dissipated

A model and a `State` never change: `step` returns a new state, and the old one can be continued in
another way. Only `advance` moves memories in place.
"""

import math
import zlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from itertools import chain
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, ClassVar, Literal, NamedTuple, Self

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from ..arrays import Array
from ..checks import number, numbers, scales
from ..errors import InputError, shown
from .certificate import ALL_ANGLES, Certificate, PoleError

Numbers = Sequence[float] | Array
POLYNOMIAL = "N·m/rad^i"  # unit of the coefficients of a polynomial of the angle
SCALINGS: Mapping[str, Callable[[float, float, float], float]] = {
    "s": lambda value, torque, angle: value,
    "N·m": lambda value, torque, angle: value * torque,
    "rad": lambda value, torque, angle: value * angle,
    "deg": lambda value, torque, angle: value * angle,
    "N·m/rad": lambda value, torque, angle: value * torque / angle,
    "N·m·s/rad": lambda value, torque, angle: value * torque / angle,
    "rad/N·m": lambda value, torque, angle: value * angle / torque,
    "deg/N·m": lambda value, torque, angle: value * angle / torque,
}
"""Parameters of models whose torques and angles are so many times as large, by unit."""
LOSS = 2  # place in a memory, after angle and torque
SURELY = 1 - 1e-9  # share of the memory bound that rounding does not lift above the bound
FIRST_REACH, FARTHEST = 1e-3, 1e6  # [rad], first and greatest distance of the search in `inverse`


@dataclass(frozen=True)
class ConfigKey:
    """One key of a model's plugin config.

    Attributes:
        name: Name of the key in MJCF.
        kind: Kind of its value: one "number", a "list" of numbers with blanks between them, "rows"
            of 1, 2, 3 ... numbers, which are end to end in MJCF, or one "word" of `words`.
        words: Allowed words; a kernel gets the position of the given word among them.
        optional: Whether the key may be left out, for the number 0, no list or the first word.
    """

    name: str
    kind: Literal["number", "list", "rows", "word"] = "number"
    words: tuple[str, ...] = ()
    optional: bool = False

    def checked(self, value: Any, unit: str) -> Any:
        """Returns a value of the key as a model keeps it: finite floats, or the word."""
        if self.kind == "number":
            return number(self.name, value, unit)
        if self.kind == "word":
            if not isinstance(value, str) or value not in self.words:
                choices = " or ".join(map(repr, self.words))
                raise InputError(f"{self.name} is {shown(value)}: use {choices}")
            return value
        if self.kind == "list":
            empty = self.optional and np.size(value) == 0
            return () if empty else numbers(self.name, value, unit)
        rows = tuple(value) if np.iterable(value) else ()
        for i, row in enumerate(rows):
            if len(numbers(f"{self.name}[{i}]", row, unit)) != i + 1:
                raise InputError(f"{self.name}[{i}] has {len(row)} numbers: give {i + 1}")
        return tuple(numbers(self.name, row, unit) for row in rows)

    def flat(self, value: Any) -> Any:
        """Returns a value of the key as MJCF has it: a number, a word or one list."""
        return [*chain(*value)] if self.kind == "rows" else value

    def nested(self, values: list[float]) -> Any:
        """Returns the value of a list as MJCF has it, with rows of 1, 2, 3 ... numbers."""
        if self.kind != "rows":
            return values
        rows = []
        while values:
            values, row = values[len(rows) + 1 :], values[: len(rows) + 1]
            rows.append(row)
        return rows


@dataclass(frozen=True, eq=False)
class State:
    """The whole memory of a model after some motion.

    Attributes:
        memory: Numbers of the kernels, read-only: angle, torque of the hysteretic part, the part of
            the past work that depends on the path, then the numbers that the model adds.
        angle: Last angle [rad].
        torque: Resistance at that angle [N·m].
    """

    memory: Array
    angle: float
    torque: float

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, State):
            return NotImplemented
        same = self.angle == other.angle and self.torque == other.torque
        return same and np.array_equal(self.memory, other.memory)

    __hash__ = None  # type: ignore[assignment]


class Energy(NamedTuple):
    """Stored energy of a model, and the energy dissipated since the start of the motion.

    Attributes:
        stored: Stored energy [J].
        dissipated: Dissipated energy [J].
    """

    stored: float
    dissipated: float


class HysteresisModel(ABC):
    """Resistance [N·m] of a joint that depends on the order of its angles [rad], not on time.

    A model is a frozen dataclass of its parameters, `config_keys` in MJCF. A class checks them in
    `__post_init__`, after that of this class, and raises an `InputError`. Its `parameter_vector` p
    has the values of all keys, end to end, unless the class overrides the property.

    The class names a module of kernels, plain numba functions over p and a memory
    s = [angle, torque, loss, ...], from which this class derives all methods but `certificate`:

        memory_size(total)                      how many of the numbers in s and p together are in
                                                s; a class whose s grows with p overrides the
                                                property `memory_size`
        begin(p, s, angle, torque)              fills s; returns how far the start is inside the
                                                states that the certificate covers: < 0 outside,
                                                NaN if the model cannot have that torque there
        move(p, s, angle)                       (torque, loss, maybe more) after a monotone motion
                                                to another angle; s unchanged
        commit(p, s, angle)                     the torque after that motion, whose end is the new
                                                memory; s stays as it is where the torque is NaN
        stiffness(p, s, angle, torque, delta)   slope there if the motion goes on with sign delta
        stored(p, s, angle, torque, loss)       the energy stored there
        dissipated(p, s, angle, torque, loss)   the energy dissipated from the start to there
        is_sound(p)                             whether the kernels can rely on p, which a user can
                                                overwrite in a saved state

    The engine plugin calls the same kernels, so a simulation and `response` agree to the last bit.
    """

    name: ClassVar[str]
    kernels: ClassVar[ModuleType]
    config_keys: ClassVar[tuple[ConfigKey, ...]] = ()
    not_fitted: ClassVar[tuple[str, ...]] = ()
    """Names of the numbers in `to_dict` that no fit chooses: grids, ranges and conventions."""
    least: ClassVar[Mapping[str, float]] = MappingProxyType({})
    """Lower bounds of numbers in `to_dict` of certified models, by name; a bound may be reached."""
    units: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Units of the parameters in `to_dict`, by name; a pure number has no entry."""

    def __post_init__(self) -> None:
        for key in self.config_keys:
            unit = self.units.get(key.name, "")
            object.__setattr__(self, key.name, key.checked(getattr(self, key.name), unit))

    def _wrong(self, name: str, what: str) -> InputError:
        """Returns the error that a parameter is wrong, with what to do about it."""
        unit = f" {self.units[name]}" if name in self.units else ""
        return InputError(f"{name} is {shown(getattr(self, name))}{unit}: {what}")

    @classmethod
    def from_config(cls, config: Mapping[str, Any]) -> Self:
        """Returns the model of a value for each of `config_keys`, which may lack a certificate."""
        return cls(**config)

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters as the kernels read them: radians and N·m, read-only."""
        return read_only(np.concatenate([np.ravel(value) for value in self.config().values()]))

    @cached_property
    def _parameters(self) -> Array:
        """A writable copy of the same numbers: kernels compile anew for read-only arrays."""
        return self.parameter_vector.copy()

    @cached_property
    def memory_size(self) -> int:
        """How many numbers the memory holds."""
        return int(self.kernels.memory_size.py_func(0))

    @abstractmethod
    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Proves limits of any motion whose angles [rad] stay in a range."""

    def scaled(self, *, torque: float = 1.0, angle: float = 1.0) -> Self:
        """Returns the model whose torque at angle * theta is `torque` times this one's at theta.

        Both scales are above 0. The result is exact for every motion: each parameter changes as its
        unit says.
        """
        scales(torque=torque, angle=angle)
        given, units = self._given(), self.units
        changed = {name: _scaled(given[name], units[name], torque, angle) for name in units}
        return replace(self, **changed)  # type: ignore[type-var]

    @property
    def free_parameters(self) -> int:
        """How many numbers a fit of the model chooses: all but the `not_fitted` numbers."""
        given = self._given().items()
        return sum(_count(value) for name, value in given if name not in self.not_fitted)

    def _given(self) -> dict[str, Any]:
        """Returns the parameters by name, without the model inside."""
        model: Any = self
        names = (field.name for field in fields(model))
        return {name: getattr(self, name) for name in names if name != "model"}

    @property
    def c_source(self) -> Path:
        """File with the kernel `commit` in C99, beside the kernels; see `c_code`."""
        return Path(str(self.kernels.__file__)).with_suffix(".c")

    def config(self) -> dict[str, Any]:
        """Returns the parameters as MJCF has them: a number, a text or a list for each key."""
        return {key.name: key.flat(getattr(self, key.name)) for key in self.config_keys}

    def to_dict(self) -> dict[str, Any]:
        """Returns name and parameters, ready for JSON; `model_from_dict` gives the model back."""
        return {"model": self.name} | {name: _plain(one) for name, one in self._given().items()}

    def response(self, angle: ArrayLike, initial_torque: float = 0.0) -> Array:
        """Computes the resistance along a sequence of angles.

        The result depends on the order of the angles, not on time. Between two samples the motion
        is taken as monotone; a repeated angle repeats its torque.

        Args:
            angle: Joint angles [rad], shape (n,).
            initial_torque: Resistance at angle[0] [N·m].

        Returns:
            Resistance [N·m], shape (n,), with torque[0] == initial_torque.

        Raises:
            PoleError: The motion meets the pole of an uncertified model.
        """
        angle = finite_series("angle", angle, "rad")
        state = self.start(angle[0], initial_torque)
        torque = self._follow(state.memory.copy(), angle, state.torque)
        if np.isnan(torque[-1]):
            last = int(np.flatnonzero(np.isnan(torque))[0])
            raise self._pole(angle[last - 1], angle[last], f" (sample {last})")
        return torque

    def _follow(self, memory: Array, angles: Array, torque: float) -> Array:
        """Moves a memory along angles [rad], in place; returns the torques [N·m], NaN from a pole.

        `torque` is that at the first angle [N·m], for models around another.
        """
        torques = np.empty_like(angles)
        responder(self.kernels)(self._parameters, memory, angles, torques)
        return torques

    def start(self, angle: float, torque: float = 0.0) -> State:
        """Begins a motion at `angle` [rad] with a known resistance [N·m]."""
        angle, torque = number("angle", angle, "rad"), number("initial torque", torque, "N·m")
        return State(read_only(self._begin(angle, torque)), angle, torque)

    def _begin(self, angle: float, torque: float) -> Array:
        """Returns the memory of a motion that begins at `angle` [rad] with a torque [N·m]."""
        memory = np.zeros(self.memory_size)
        if math.isnan(self.kernels.begin(self._parameters, memory, angle, torque)):
            raise InputError(
                f"initial torque is {torque:.6g} N·m at {angle:.6g} rad: this {self.name} model "
                "cannot have that torque there; start nearer to 0 N·m"
            )
        return memory

    def start_is_certified(self, state: State) -> bool:
        """Returns whether the certificate covers motions that start in `state`."""
        s, rest = state.memory, self.anhysteretic(state)
        if rest is not None:
            return abs(s[1] - rest) <= self.certificate().memory_bound
        scratch = np.zeros(self.memory_size)
        return bool(self.kernels.begin(self._parameters, scratch, s[0], s[1]) >= 0)

    def anhysteretic(self, state: State) -> float | None:
        """Returns the torque [N·m] to which the memory bound of the certificate refers.

        The result is None for a model whose kernel `begin` decides which starts are certified.
        """
        return None

    def step(self, state: State, angle: float) -> tuple[State, float]:
        """Returns the state after a motion to `angle` [rad], and the resistance [N·m] there.

        Steps give the same torques as `response`, bit for bit.

        Raises:
            PoleError: The motion meets the pole of an uncertified model.
        """
        angle = number("angle", angle, "rad")
        if angle == state.angle:
            return state, state.torque
        memory = state.memory.copy()
        torque = float(self._move(memory, angle))
        if math.isnan(torque):
            raise self._pole(state.angle, angle)
        memory.setflags(write=False)
        return State(memory, angle, torque), torque

    def _move(self, memory: Array, angle: float) -> float:
        """Moves a memory to `angle` [rad], in place; returns the torque [N·m], NaN at a pole."""
        return self.kernels.commit(self._parameters, memory, angle)

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory with which this model continues the motion of another model.

        The angle stays, and the dissipated energy goes on from its value. Each model of this
        package keeps its inner state, from which the torque follows: the torque changes no more
        than the parameters do, and `scaled(torque=s)` makes the torque s times as large. A class
        without a `carry_over` of its own keeps the torque, with the memory that `begin` fills in.

        Args:
            memory: Memory of the other model, of the same class and size, shape (memory_size,).
            parameters: Parameters of the other model, as `parameter_vector` has them.
        """
        return self._at_torque(float(memory[1]), memory, parameters)

    def _at_torque(self, torque: float, memory: Array, parameters: Array) -> Array:
        """Returns a memory with the angle and losses of another model's, and a torque [N·m]."""
        begun = self.start(float(memory[0]), torque).memory.copy()
        return self._keep_loss(begun, memory, parameters)

    def _keep_loss(self, own: Array, memory: Array, parameters: Array) -> Array:
        """Gives the memory `own` the dissipated energy of another model's; returns `own`."""
        s = memory.copy()
        lost = self.kernels.dissipated(parameters.copy(), s, s[0], s[1], 0.0)
        own[LOSS] += lost - self.kernels.dissipated(self._parameters, own, own[0], own[1], 0.0)
        return own

    def _covered(self, angle: float, torque: float) -> float:
        """Returns the certified torque [N·m] at an angle [rad] that is nearest to `torque`."""
        certificate = self.certificate()

        def lag(torque: float) -> float:
            state = self.start(angle, torque)
            rest = self.anhysteretic(state)
            return 0.0 if rest is None else float(state.memory[1]) - rest

        wanted = math.copysign(SURELY * certificate.memory_bound, lag(torque))
        if not certificate.certified or abs(lag(torque)) <= abs(wanted):
            return torque
        from scipy.optimize import brentq

        # The lag rises with the torque where the model has a certificate.
        other = -math.copysign(certificate.torque_bound, wanted)
        root: Any = brentq(lambda torque: lag(torque) - wanted, torque, other)
        return float(root)

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves each memory to its angle, in place; returns the torques at the angles `soon`.

        The memories stay at `angle`: the motions from there to `soon` are trials.

        Args:
            memories: Memories as `State` has them, shape (n, memory_size).
            angle: Angle to which each memory moves [rad], shape (n,).
            soon: Angle of each returned torque [rad], shape (n,).

        Returns:
            Resistance at the angles `soon` [N·m], shape (n,).

        Raises:
            PoleError: A motion meets the pole of an uncertified model.
        """
        torque = np.empty(len(memories))
        for row, memory in enumerate(memories):
            before = memory[0]
            self._move(memory, angle[row])
            torque[row] = self._move(memory.copy(), soon[row])
            if math.isnan(torque[row]):
                raise self._pole(float(before), float(soon[row]))
        return torque

    def tangent(self, state: State, direction: float) -> float:
        """Returns the stiffness [N·m/rad] of a motion that goes on with the sign `direction`."""
        s, delta = state.memory.copy(), math.copysign(1.0, direction)
        return float(self.kernels.stiffness(self._parameters, s, s[0], s[1], delta))

    def energy(self, state: State) -> Energy:
        """Returns the energy stored in `state` and dissipated since its start [J].

        Each model chooses the state in which its stored energy is zero; only differences matter.
        Stored plus dissipated energy changes by exactly the work done on the model. If the
        certificate says `dissipative`, the dissipated part never decreases (by more than the
        tolerance of a step: for Jiles-Atherton 1e-9 k Ms with k in radians).
        """
        s = state.memory.copy()
        there = (self._parameters, s, s[0], s[1], 0.0)
        return Energy(float(self.kernels.stored(*there)), float(self.kernels.dissipated(*there)))

    def inverse(self, torque: ArrayLike, initial_angle: float = 0.0) -> Array:
        """Computes the angles along which the resistance follows given torques.

        Args:
            torque: Resistance [N·m], shape (n,).
            initial_angle: Angle of torque[0] [rad].

        Returns:
            Angles [rad], shape (n,), with angle[0] == initial_angle; `response` gives the torques
            back. Where several angles give a torque, the result is the first on the way.
        """
        torque = finite_series("torque", torque, "N·m")
        state = self.start(initial_angle, torque[0])
        angle = np.empty_like(torque)
        angle[0] = initial_angle
        for i in range(1, torque.size):
            angle[i] = find_angle(self, state, torque[i], f"torque[{i}]")
            state, _ = self.step(state, angle[i])
        return angle

    def _pole(self, start: float, end: float, where: str = "") -> PoleError:
        certificate = self.certificate()
        if certificate.certified:
            why = (
                "the motion began outside the model's certificate, further than "
                f"{certificate.memory_bound:.3g} N·m from the torque at rest: start nearer to that"
            )
        else:
            why = (
                f"the model's certificate margin is {certificate.margin:.3g} and must be above 0 "
                "for arbitrary motions"
            )
        return PoleError(
            f"the torque becomes infinite between {start:.6g} and {end:.6g} rad{where}; {why}"
        )


def stamp_of(kernels: ModuleType, files: Iterable[Path] = ()) -> int:
    """Returns a number, at least 0, that changes with `files` and any file beside the kernels.

    Numba checks the file of a cached function only, not the files of the functions that are called
    inside. A function that mentions the number is compiled anew when the number changes.
    """
    beside = Path(getattr(kernels, "__file__", None) or __file__).parent.glob("*.py")
    stats = [(path.name, path.stat()) for path in sorted({*beside, *files})]
    seen = [(name, stat.st_mtime_ns, stat.st_size) for name, stat in stats]
    return zlib.crc32(repr(seen).encode())


@cache
def responder(kernels: ModuleType) -> Callable[[Array, Array, Array, Array], None]:
    """Compiles the response of a model, once for each module of kernels.

    The compiled function moves a memory s along `angles` [rad], shape (n,), and fills `torques`
    [N·m], shape (n,). From a failure onwards, as at a pole, the torques are NaN.
    """
    version = stamp_of(kernels)

    @njit(cache=True, nogil=True, error_model="numpy")
    def respond(p, s, angles, torques):
        torques[0] = s[1] if version >= 0 else math.nan
        for i in range(1, angles.size):
            torques[i] = kernels.commit(p, s, angles[i])
            if math.isnan(torques[i]):
                torques[i:] = math.nan
                return

    return respond


def _plain(value: Any) -> Any:
    """Returns a parameter as JSON has it, with lists in place of tuples."""
    return [_plain(one) for one in value] if isinstance(value, tuple) else value


def _count(value: Any) -> int:
    """Returns how many numbers a parameter has."""
    if isinstance(value, tuple):
        return sum(map(_count, value))
    return 0 if isinstance(value, bool | str) else 1


def _scaled(value: Any, unit: str, torque: float, angle: float) -> Any:
    """Returns a parameter for torques and angles that are `torque` and `angle` times as large."""
    if unit == POLYNOMIAL:
        return [one * torque / angle**power for power, one in enumerate(value)]
    if isinstance(value, tuple):
        return tuple(_scaled(one, unit, torque, angle) for one in value)
    return SCALINGS[unit](value, torque, angle)


def finite_series(name: str, values: ArrayLike, unit: str) -> Array:
    """Returns `values` as one finite series, shape (n,)."""
    try:
        series = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name} is not a series of real numbers ({unit}): {error}") from error
    if series.ndim != 1 or series.size == 0:
        raise InputError(f"{name} has shape {series.shape}: give one series of at least 1 sample")
    if not np.isfinite(series).all():
        bad = int(np.flatnonzero(~np.isfinite(series))[0])
        raise InputError(f"{name}[{bad}] is {series[bad]}: give finite numbers ({unit})")
    return series


def follow(model: HysteresisModel, state: State, angles: Iterable[float]) -> State:
    """Returns the state after monotone motions from `state` to each of some angles [rad]."""
    for angle in angles:
        state, _ = model.step(state, angle)
    return state


def find_angle(model: HysteresisModel, state: State, target: float, what: str) -> float:
    """Returns the first angle [rad] at which a motion from `state` meets the torque `target`."""
    from scipy.optimize import brentq  # a third of the package's import time

    missing = target - state.torque
    if missing == 0:
        return state.angle
    here, direction = state.angle, math.copysign(1.0, missing)
    if model.tangent(state, direction) < 0:
        direction = -direction

    def excess(distance: float) -> float:
        return model.step(state, here + direction * distance)[1] - target if distance else -missing

    near, far = 0.0, FIRST_REACH
    try:  # the distance grows until the torque has passed the target
        while far <= FARTHEST and excess(far) * missing < 0:
            near, far = far, 1.5 * far
    except PoleError:
        far = math.inf
    if far > FARTHEST:
        raise InputError(
            f"{what} is {target:.6g} N·m: no motion from {here:.6g} rad, {state.torque:.6g} N·m "
            "reaches it; keep torques within the model's torque bound"
        )
    root: Any = brentq(excess, near, far, xtol=1e-14, rtol=np.float64(1e-14))
    return here + direction * float(root)


def read_only(values: ArrayLike) -> Array:
    """Returns a read-only float64 copy of `values`."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array
