"""The wearer, the coupling and the load, as command line options that several commands share."""

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

import tyro

from ..envs.model import ArmConfig
from ..envs.model.config import COUPLINGS, SIDES, place_of
from ..envs.person.anthropometry import SEXES, Person
from ..errors import InputError, shown
from .options import GRAVITY, SUIT, choice, optional_number
from .settings import joined, settings

_USUAL = ArmConfig()
_NESTED = {  # options whose place in `ArmConfig` is deeper
    **{name: ("wearer", name) for name in ("stature", "mass", "sex", "strength")},
    "payload": ("payload", "mass"),
}
_GROUPS = ("wearer", "payload")
_OR = ", or with --sex female the mean of women"

# Each `--set` takes several values, and may be there several times.
Settings = Annotated[
    tuple[tuple[str, ...], ...],
    tyro.conf.UseAppendAction,
    tyro.conf.arg(metavar="NAME=VALUE ..."),
]


@dataclass(frozen=True, kw_only=True)
class ArmOptions:
    """Wearer, coupling, load, and any option of the environment.

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
        set: Any options of the environment, by their names in Python, with a dot before the field
            of a nested one: fatigue=true sensing.rate_cutoff=10 max_episode_steps=500.
    """

    # None where the option is not given; `runs.scene` finds what it is then.
    pressure: Annotated[float | None, optional_number("that of its file")] = None
    preconditioned: bool = False
    coupling: Annotated[str | None, choice(lambda: COUPLINGS, usual=_USUAL.coupling)] = None
    side: Annotated[str | None, choice(lambda: SIDES, usual=_USUAL.side)] = None
    stature: Annotated[float | None, optional_number(f"{_USUAL.wearer.stature}{_OR}")] = None
    mass: Annotated[float | None, optional_number(f"{_USUAL.wearer.mass}{_OR}")] = None
    sex: Annotated[str | None, choice(lambda: SEXES, usual=_USUAL.wearer.sex)] = None
    strength: Annotated[float | None, optional_number(f"{_USUAL.wearer.strength}")] = None
    payload: Annotated[float | None, optional_number(f"{_USUAL.payload.mass}")] = None
    tilt: Annotated[tuple[float, float] | None, optional_number("0.0 0.0", count=2)] = None
    allow_uncertified: bool = False
    set: Settings = ()

    def given(self, **flags: Any) -> dict[str, Any]:
        """Returns the options that are given by flags and by `--set`, as `flat_options` does.

        Args:
            **flags: Flags of the command beside these; None where one is not given.
        """
        mine = {name: value for name, value in asdict(self).items() if name != "set"}
        if mine["tilt"] is not None:
            mine["tilt"] = list(mine["tilt"])
        present = {
            name: value
            for name, value in {**mine, **flags}.items()
            if value is not None and value is not False
        }
        others = flat_options(settings([one for together in self.set for one in together]))
        for one in (present, others):
            if "gravity" in one:
                one["gravity"] = place_of("gravity", one["gravity"])
        return joined(present, others)

    def config(self, suit: str | None, gravity: str | None) -> dict[str, Any]:
        """Returns the fields of `ArmConfig` where no training run is involved, as plain values."""
        given = self.given(suit=suit, gravity=gravity)
        return nested_options({**USUAL_OPTIONS, **usual_size(given), **given})

    def split(self, names: Collection[str]) -> tuple[dict[str, Any], "ArmOptions"]:
        """Returns what `--set` gives of some options, and the options without."""
        given = [one for together in self.set for one in together]
        mine = [one for one in given if one.partition("=")[0].split(".")[0] in names]
        others = tuple(one for one in given if one not in mine)
        return settings(mine), replace(self, set=(others,))


def usual_size(given: Mapping[str, Any]) -> dict[str, float]:
    """Returns stature [m] and mass [kg] of a wearer of whom only the sex may be given."""
    person = Person(sex=given.get("sex", _USUAL.wearer.sex))
    return {"stature": person.stature, "mass": person.mass}


def flat_options(config: dict[str, Any]) -> dict[str, Any]:
    """Returns options of an environment by the names of flags, where there are such.

    Other fields of wearer and payload have their place as their name, such as "payload.inertia".
    """
    flags = {place: name for name, place in _NESTED.items()}
    flat = {name: value for name, value in config.items() if name not in _GROUPS}
    for group in _GROUPS:
        fields = config.get(group, {})
        if not isinstance(fields, dict):
            raise InputError(f"{group} is {shown(fields)}: give its fields, as in {group}.mass=3")
        for inner, value in fields.items():
            flat[flags.get((group, inner), f"{group}.{inner}")] = value
    return flat


def nested_options(flat: dict[str, Any]) -> dict[str, Any]:
    """Returns the options of an environment from what `flat_options` returns."""
    config: dict[str, Any] = {}
    for name, value in flat.items():
        group, _, inner = name.partition(".")
        if name in _NESTED:
            group, inner = _NESTED[name]
        if inner:
            config.setdefault(group, {})[inner] = value
        else:
            config[name] = value
    return config


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
