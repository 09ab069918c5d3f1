"""The wearer, the coupling and the load, as command line options that several commands share."""

from dataclasses import asdict, dataclass
from typing import Annotated, Any

from ..envs.model import ArmConfig
from ..envs.model.config import COUPLINGS, SIDES
from ..envs.person.anthropometry import SEXES
from .options import GRAVITY, SUIT, choice, optional_number

_USUAL = ArmConfig()
_NESTED = {  # options whose place in `ArmConfig` is deeper
    **{name: ("wearer", name) for name in ("stature", "mass", "sex", "strength")},
    "payload": ("payload", "mass"),
}


@dataclass(frozen=True, kw_only=True)
class ArmOptions:
    """Wearer, coupling and load.

    A training run brings its own: then leave these options out.

    Attributes:
        pressure: Operating pressure of the suit [kPa], to which its torque is proportional.
        preconditioned: Begin with the memory of a suit that was moved before, in the steady cycle
            over the range of each joint, and not with that of a new one.
        coupling: Connection of the exoskeleton to the arm: rigid, elastic cuffs, or none, which
            means that there is no exoskeleton.
        side: Arm that wears the exoskeleton.
        stature: Height of the wearer [m].
        mass: Mass of the wearer's body [kg].
        sex: Sex of the wearer, which decides the proportions and the strength.
        strength: Percentile of the wearer's strength among people of that sex and mass.
        payload: Mass of the load at the hand [kg].
        tilt: Angles of the torso, forward and to the right [rad].
        allow_uncertified: Accept a suit whose torque could become infinite in some motion.
    """

    # None where the option is not given; `runs.scene` finds what it is then.
    pressure: Annotated[float | None, optional_number("that of its file")] = None
    preconditioned: bool = False
    coupling: Annotated[str | None, choice(lambda: COUPLINGS, usual=_USUAL.coupling)] = None
    side: Annotated[str | None, choice(lambda: SIDES, usual=_USUAL.side)] = None
    stature: Annotated[float | None, optional_number(f"{_USUAL.wearer.stature}")] = None
    mass: Annotated[float | None, optional_number(f"{_USUAL.wearer.mass}")] = None
    sex: Annotated[str | None, choice(lambda: SEXES, usual=_USUAL.wearer.sex)] = None
    strength: Annotated[float | None, optional_number(f"{_USUAL.wearer.strength}")] = None
    payload: Annotated[float | None, optional_number(f"{_USUAL.payload.mass}")] = None
    tilt: Annotated[tuple[float, float] | None, optional_number("0.0 0.0", count=2)] = None
    allow_uncertified: bool = False

    def given(self) -> dict[str, Any]:
        """Returns the options that are given, by their names."""
        return {
            name: list(value) if name == "tilt" else value
            for name, value in asdict(self).items()
            if value is not None and value is not False
        }

    def config(self, suit: str | None, gravity: str | None) -> dict[str, Any]:
        """Returns the fields of `ArmConfig` where no training run is involved, as plain values."""
        return nested_options(
            {**USUAL_OPTIONS, **self.given(), **_present(suit=suit, gravity=gravity)}
        )


def flat_options(config: dict[str, Any]) -> dict[str, Any]:
    """Returns the options of the command line that make the given fields of `ArmConfig`."""
    flat = {name: value for name, value in config.items() if name not in ("wearer", "payload")}
    for name, (group, inner) in _NESTED.items():
        if inner in config.get(group, {}):
            flat[name] = config[group][inner]
    return flat


def nested_options(flat: dict[str, Any]) -> dict[str, Any]:
    """Returns the fields of `ArmConfig` that options of the command line make."""
    config: dict[str, Any] = {}
    for name, value in flat.items():
        if name in _NESTED:
            group, inner = _NESTED[name]
            config.setdefault(group, {})[inner] = value
        else:
            config[name] = value
    return config


def _present(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


USUAL = ArmOptions()
USUAL_OPTIONS: dict[str, Any] = {
    "suit": SUIT,
    "pressure": _USUAL.pressure,
    "preconditioned": _USUAL.preconditioned,
    "gravity": GRAVITY,
    "stature": _USUAL.wearer.stature,
    "mass": _USUAL.wearer.mass,
    "sex": _USUAL.wearer.sex,
    "strength": _USUAL.wearer.strength,
    "coupling": _USUAL.coupling,
    "payload": _USUAL.payload.mass,
    "side": _USUAL.side,
    "tilt": list(_USUAL.tilt),
    "allow_uncertified": _USUAL.allow_uncertified,
}
