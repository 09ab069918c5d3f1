"""A suit: hysteresis models by joint, the operating pressure, and the suit file (JSON)."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, FiniteFloat, ValidationError, field_validator

from ..errors import InputError, shown, unknown_name
from ..files import write_text
from ..hysteresis import HysteresisModel
from ..json_files import read_json
from .suit_joints import JOINTS, FittedModel, Strict, SuitJoint, first_problem

SCHEMA_VERSION = 2
Label = Literal["from paper", "illustrative", "extrapolated"]
FOLDER = Path(__file__).parent / "suits"
HIGHEST_PRESSURE = 110.0  # kPa: a little above the atmosphere at sea level


class Suit(Strict):
    """A suit: hysteresis models by joint. Joints that are not listed move freely.

    Attributes:
        schema_version: Version of the file format.
        name: Name of the suit.
        description: Description of the suit, and of the quality of its numbers.
        label: Origin of the numbers: "from paper" (published numbers), "illustrative" (numbers of
            a plausible size that belong to no real suit) or "extrapolated" (numbers of another
            pressure); None for your own suits.
        pressure_kpa: Operating pressure at which the torques were measured [kPa], above 0 and at
            most 110; None if the pressure is not known.
        joints: Resistance of each joint, by the name of the joint.
    """

    schema_version: Literal[2] = SCHEMA_VERSION
    name: Annotated[str, Field(min_length=1)]
    description: str
    label: Label | None = None
    pressure_kpa: FiniteFloat | None = None
    joints: dict[Literal[JOINTS], SuitJoint]  # type: ignore[valid-type]

    @field_validator("pressure_kpa")
    @classmethod
    def _is_in_kpa(cls, pressure: float | None) -> float | None:
        if pressure is not None and not 0 < pressure <= HIGHEST_PRESSURE:
            raise ValueError(
                f"it is {pressure:g}: give kPa above 0, at most {HIGHEST_PRESSURE:g}, or leave it "
                "out if it is not known"
            )
        return pressure

    @classmethod
    def from_fits(
        cls,
        fits: Mapping[str, FittedModel],
        *,
        name: str = "identified",
        description: str = "",
        base: "Suit | None" = None,
        samples: Mapping[str, Sequence[HysteresisModel]] | None = None,
        left_open: Mapping[str, Sequence[str]] | None = None,
    ) -> "Suit":
        """Returns the suit whose joints resist as the fitted models do.

        Args:
            fits: Results of `activesuit.identification.identify`, by joint.
            name: Name of the suit.
            description: Description of the suit; by default the methods and the fitted curves.
            base: Suit that gives the joints without a fit; by default these joints move freely.
            samples: Other models that the curves allow too, by joint, for randomization.
            left_open: Phrases about effects that the curves do not determine and the samples lack,
                by joint.
        """
        if not isinstance(fits, Mapping) or not fits:
            raise InputError(
                f"fits is {shown(fits)}: give fits by joint, as {{'elbow_flexion': fit}}"
            )
        samples, left_open = samples or {}, left_open or {}
        for joint in (*fits, *samples, *left_open):
            if joint not in JOINTS:
                raise unknown_name("joint", joint, JOINTS)
            if joint not in fits:
                raise InputError(f"samples has {joint!r}, which has no fit: leave it out")
        identified = {
            joint: SuitJoint.from_fit(
                fit, samples=samples.get(joint, ()), left_open=left_open.get(joint, ())
            )
            for joint, fit in fits.items()
        }
        fits_text = [
            f"{joint} from {fit.curves.source or 'curves'} by {fit.method}"
            for joint, fit in fits.items()
        ]
        try:
            return cls(
                name=name,
                description=description or f"Identified: {'; '.join(fits_text)}.",
                joints={**(base.joints if base else {}), **identified},
            )
        except ValidationError as error:
            raise InputError(first_problem(error)) from error

    def __hash__(self) -> int:
        """Returns a hash of the whole content, which equal suits share."""
        return hash(self.model_dump_json())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a suit file that `load_suit` reads back, in one piece."""
        write_text(path, self.model_dump_json(indent=2, exclude_none=True) + "\n")

    def at_pressure(self, pressure: float) -> "Suit":
        """Returns the suit at another operating pressure.

        Bending displaces gas, which makes most of the torque of a pressurized elbow (volume effect:
        Holschuh 2010, MIT). In a joint with a `volume_share` that share of the elastic torque
        changes, which dissipates nothing; the torque that remains at 0 kPa is of the structure.
        Without a `volume_share` the whole torque is assumed to be proportional to the pressure,
        friction included.

        Args:
            pressure: Operating pressure [kPa], 0 to 110; at 0 joints without a `volume_share` do
                not resist.
        """
        if not 0 <= pressure <= HIGHEST_PRESSURE:
            raise InputError(f"pressure is {pressure:g} kPa: give 0 to {HIGHEST_PRESSURE:g} kPa")
        if self.pressure_kpa is None:
            raise InputError(
                f"pressure is {pressure:g} kPa, but the suit {self.name!r} does not tell at which "
                "its torque was measured: take a suit that does (--suit emu-like), add "
                "pressure_kpa to its file, or leave pressure out"
            )
        if pressure == self.pressure_kpa:
            return self
        factor = pressure / self.pressure_kpa
        own = f"{self.pressure_kpa:g} kPa"
        how = f"{factor:.3g} times its torque at {own}"
        if any(entry.volume_share is not None for entry in self.joints.values()):
            how = f"extrapolated from {own} by the volume_share of its joints"
        return Suit(
            name=f"{self.name}-{pressure:g}kPa",
            description=f"{self.name} at {pressure:g} kPa: {how}. {self.description}",
            label="extrapolated",
            pressure_kpa=pressure or None,
            joints={
                joint: entry.at_pressure_ratio(factor)
                for joint, entry in self.joints.items()
                if factor > 0 or entry.volume_share is not None
            },
        )

    def after(self, cycles: float) -> "Suit":
        """Returns the suit as after a number of cycles of motion; see `SuitJoint.after`."""
        joints = {joint: entry.after(cycles) for joint, entry in self.joints.items()}
        return self.model_copy(update={"joints": joints})

    def preconditioned(self) -> "Suit":
        """Returns the suit in which the memory of every joint begins in its steady cycle.

        A new suit resists its first loading less than all later loadings; see
        `SuitJoint.preconditioned`.
        """
        joints = {joint: entry.preconditioned() for joint, entry in self.joints.items()}
        return self.model_copy(update={"joints": joints})


AnySuit = str | os.PathLike[str] | Suit | Mapping[str, Any]  # what `load_suit` takes


def suit_names() -> list[str]:
    """Returns the names of the suits that ship with the package."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load_suit(suit: AnySuit) -> Suit:
    """Returns a shipped suit by its name, a suit from a JSON file, or a suit from objects.

    Args:
        suit: Name of a shipped suit or path of a file; or a `Suit`, which is returned unchanged; or
            `SuitJoint`s by the name of their joint; or the content of a suit file as a dict.
    """
    if isinstance(suit, Suit):
        return suit
    if isinstance(suit, Mapping):
        if any(isinstance(value, SuitJoint) for value in suit.values()):
            custom = {"name": "custom", "description": "Joints given as objects."}
            suit = {"schema_version": SCHEMA_VERSION, **custom, "joints": dict(suit)}
        return _checked(dict(suit), "suit")
    if isinstance(suit, SuitJoint):
        raise InputError(
            "suit is a SuitJoint, which has no joint name of its own: give it by the name of its "
            "joint, as {'elbow_flexion': joint}"
        )
    if not isinstance(suit, (str, os.PathLike)):
        raise InputError(
            f"suit is {shown(suit)}: give the name of a shipped suit, the path of a suit file, a "
            "Suit, or SuitJoints by joint"
        )
    text = os.fspath(suit)
    is_path = text.endswith(".json") or Path(text).name != text
    path = Path(text) if is_path else FOLDER / f"{text}.json"
    if path.parent == FOLDER and text not in suit_names():
        error = unknown_name("suit", text, suit_names())
        raise InputError(f"{error}; or give the path of a .json file")
    return _checked(read_json(path, "suit"), path)


def _checked(content: Any, place: object) -> Suit:
    version = content.get("schema_version") if isinstance(content, dict) else None
    if type(version) is not int or version != SCHEMA_VERSION:
        raise InputError(
            f"{place}: schema_version is {shown(version)}, and this release reads "
            f"{SCHEMA_VERSION}: remake it with `activesuit identify CURVES.csv --out DIR`"
        )
    try:
        return Suit.model_validate(content)
    except ValidationError as error:
        raise InputError(f"{place}: {first_problem(error)}") from error
