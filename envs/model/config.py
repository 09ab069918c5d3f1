"""The configuration of a model, as plain values: wearer, suit, exoskeleton, load and place."""

import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from typing import Any, Literal, TypeVar

from ...assets import AnySuit, Suit, load_suit
from ...assets.suits import HIGHEST_PRESSURE
from ...checks import flag, within
from ...errors import InputError, refuse_old_names, unknown_name
from ..person import Person
from ..provenance import check_settings, numbers_of, setting, values_of
from .exoskeleton import Exo

NO_SUIT = "none"
COUPLINGS = ("rigid", "cuffs", "none")
SIDES = ("right", "left")
HEAVIEST_PAYLOAD = 60.0  # kg
LARGEST_MISALIGNMENT = 0.05  # m
STEEPEST = math.pi / 2  # rad

PROVENANCE = numbers_of("gravity", "payload")
_VALUE = values_of(PROVENANCE)
_DENSITY = _VALUE.pop("payload.density")  # kg/m³
GRAVITY = {name.removeprefix("gravity."): value for name, value in _VALUE.items()}  # m/s²

Config = TypeVar("Config")


@dataclass(frozen=True, kw_only=True)
class Payload:
    """A rigid load in the ring of the exoskeleton, or in the hand without an exoskeleton.

    Attributes:
        mass: Mass of the load [kg], 0 to 60; 0 means no load. Stability of the default time step
            was tested with at most 5 kg.
        inertia: Moments of inertia about its center, in the axes of the hanging hand (x forward,
            y left, z up) [kg·m²]; by default those of a solid sphere of aluminum.
    """

    mass: float = setting(0.0, "kg", 0, HEAVIEST_PAYLOAD)
    inertia: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        check_settings(self, "payload.")
        if self.inertia is None:
            return
        object.__setattr__(self, "inertia", _numbers("payload.inertia", self.inertia, 3))
        if self.mass == 0:
            raise InputError(f"payload.inertia is {self.inertia}, but its mass is 0: give a mass")
        if min(self.inertia) <= 0 or 2 * max(self.inertia) > sum(self.inertia):
            raise InputError(
                f"payload.inertia is {self.inertia}: use moments above 0, none of them greater "
                "than the other two together"
            )

    @property
    def radius(self) -> float:
        """Radius of the sphere that shows the load [m]."""
        return (3 * self.mass / (4 * math.pi * _DENSITY)) ** (1 / 3)

    @property
    def moments(self) -> tuple[float, float, float]:
        """Moments of inertia [kg·m²]: `inertia` if it is given, or else those of the sphere."""
        ball = 0.4 * self.mass * self.radius**2
        return self.inertia or (ball, ball, ball)


@dataclass(frozen=True, kw_only=True)
class ArmConfig:
    """The configuration of a model, in plain values, which `to_dict` and `from_dict` convert.

    Nested fields also take a dict of the values that differ from their defaults, as in
    `ArmConfig(wearer={"stature": 1.6}, exo={"elbow": {"peak_torque": 30}})`.

    Attributes:
        suit: Name of a shipped suit, path of a suit file, or "none" for no suit; or a `Suit`, or
            `SuitJoint`s by the name of their joint.
        pressure: Operating pressure of the suit [kPa], to which its torque, or the gas's part of
            it, is proportional; by default that of the suit file.
        preconditioned: Whether the suit's memory begins in the steady cycle over the range of each
            joint, as in a preconditioned suit, instead of on the virgin curve of a new one; where
            the suit file gives a softening, the torque is then that after many cycles.
        gravity: Place, whose gravity acts: "earth", "mars", "moon" or "microgravity".
        wearer: Person who wears the suit.
        exo: Exoskeleton on the arm.
        coupling: Connection of the exoskeleton: "rigid" (it shares the arm's joints), "cuffs" (it
            has its own joints, and elastic cuffs connect it) or "none" (there is no exoskeleton).
        payload: Load at the hand.
        side: Arm that is simulated, "right" or "left".
        tilt: Pitch (forward positive) and roll (to the wearer's right positive) of the torso on the
            hips, each within a right angle [rad].
        misalignment: Position of the exoskeleton's axes relative to the arm's, with the arm
            hanging: forward, outward, up [m]; at most 0.05 m each way, and with cuffs only.
        sim_dt: Physics step [s]; by default 0.002, with cuffs 0.001.
        allow_uncertified: Whether to accept suits whose torque could become infinite in some
            motion.
    """

    suit: AnySuit = "mock-suit"
    pressure: float | None = setting(None, "kPa", 0, HIGHEST_PRESSURE)
    preconditioned: bool = False
    gravity: str = "earth"
    wearer: Person = field(default_factory=Person)
    exo: Exo = field(default_factory=Exo)
    coupling: Literal["rigid", "cuffs", "none"] = "rigid"
    payload: Payload = field(default_factory=Payload)
    side: Literal["right", "left"] = "right"
    tilt: tuple[float, float] = (0.0, 0.0)
    misalignment: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sim_dt: float | None = setting(None, "s", 1e-5, 0.01)
    allow_uncertified: bool = False

    def __post_init__(self) -> None:
        for name, default in _NESTED.items():
            object.__setattr__(self, name, nested(name, getattr(self, name), default))
        given = self.suit
        suit = os.fspath(given) if isinstance(given, str | os.PathLike) else load_suit(given)
        object.__setattr__(self, "suit", suit)
        for name, size in (("tilt", 2), ("misalignment", 3)):
            object.__setattr__(self, name, _numbers(name, getattr(self, name), size))
        object.__setattr__(self, "gravity", place_of("gravity", self.gravity))
        for name, known in (("coupling", COUPLINGS), ("side", SIDES)):
            if getattr(self, name) not in known:
                raise unknown_name(name, getattr(self, name), known)
        check_settings(self, "")
        for angle in self.tilt:
            within("tilt", angle, -STEEPEST, STEEPEST, " rad")
        flag("preconditioned", self.preconditioned)
        flag("allow_uncertified", self.allow_uncertified)
        if self.suit == NO_SUIT and (self.preconditioned or self.pressure is not None):
            given = "preconditioned is True"
            given = given if self.preconditioned else f"pressure is {self.pressure} kPa"
            raise InputError(f"{given}, but suit is 'none': leave one of them out")
        self._check_coupling()

    @property
    def timestep(self) -> float:
        """The physics step [s]."""
        return self.sim_dt or (0.001 if self.coupling == "cuffs" else 0.002)

    def to_dict(self) -> dict[str, Any]:
        """Returns all fields for JSON; nested fields are dicts."""
        plain = asdict(self)
        if isinstance(self.suit, Suit):
            plain["suit"] = self.suit.model_dump(mode="json")
        return plain

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "ArmConfig":
        """Returns the config with the fields in `values`, the others at their defaults."""
        return nested("config", values, cls())

    def _check_coupling(self) -> None:
        if self.coupling == "none" and self.exo != Exo():
            raise InputError("exo is given, but coupling is 'none': use 'rigid' or 'cuffs'")
        if self.coupling != "cuffs" and any(self.misalignment):
            raise InputError(
                f"misalignment is {self.misalignment}, but coupling is {self.coupling!r}: only "
                "coupling='cuffs' lets exoskeleton and arm have different axes"
            )
        for name, length in self.exo.lengths.items():
            if length is not None and self.coupling != "cuffs":
                raise InputError(
                    f"exo.{name}_length is {length}, but coupling is {self.coupling!r}: only "
                    "coupling='cuffs' lets exoskeleton and arm have different lengths"
                )
        for distance in self.misalignment:
            limit = LARGEST_MISALIGNMENT
            within("misalignment", distance, -limit, limit, " m")


_NESTED = {"wearer": Person(), "exo": Exo(), "payload": Payload()}


def nested(name: str, value: Any, default: Config) -> Config:
    """Returns `value`, or `default` with the fields that `value` replaces if `value` is a dict."""
    if isinstance(value, type(default)):
        return value
    kind = type(default)
    if not isinstance(value, Mapping):
        raise InputError(f"{name} is {value!r}: give {kind.__name__}(...) or a dict of its fields")
    assert is_dataclass(default) and not isinstance(default, type)
    known = [one.name for one in fields(default)]
    new = {}
    for field_name, given in value.items():
        if field_name not in known:
            raise unknown_name(f"field of {name}", field_name, known)
        old = getattr(default, field_name)
        new[field_name] = nested(f"{name}.{field_name}", given, old) if is_dataclass(old) else given
    if default == Person():
        return kind(**new)  # the sex decides the sizes that are not given
    return replace(default, **new)


def place_of(what: str, given: Any) -> str:
    """Returns the name of a place that `GRAVITY` has; `what` names it in the message."""
    refuse_old_names([given], {"weightless": "microgravity"})
    if not isinstance(given, str) or given not in GRAVITY:
        raise unknown_name(what, given, GRAVITY)
    return given


def _numbers(name: str, values: Any, size: int) -> Any:
    try:
        numbers = tuple(float(value) for value in values)
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != size or not all(map(math.isfinite, numbers)):
        raise InputError(f"{name} is {values!r}: give {size} finite numbers")
    return numbers
