"""Suit files: which hysteresis model resists which joint, and where its numbers come from."""

import json
import math
import os
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    FiniteFloat,
    InstanceOf,
    PlainSerializer,
    ValidationError,
    field_validator,
    model_validator,
)

from ..errors import InputError, unknown_name
from ..files import write_text
from ..hysteresis import HysteresisModel, model_from_dict

SCHEMA_VERSION = 2
JOINTS = ("shoulder_abduction", "shoulder_flexion", "elbow_flexion", "wrist_flexion")
Grade = Literal["published", "identified", "assumed"]
GRADES: tuple[str, ...] = get_args(Grade)
Label = Literal["from paper", "illustrative", "extrapolated"]
HIGHEST_PRESSURE = 110.0  # kPa: a little above the atmosphere at sea level
FOLDER = Path(__file__).parent / "suits"


def _model(given: Any) -> HysteresisModel:
    return given if isinstance(given, HysteresisModel) else model_from_dict(given)


Model = Annotated[
    InstanceOf[HysteresisModel],
    BeforeValidator(_model),
    PlainSerializer(lambda model: model.to_dict()),
]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class SuitJoint(_Strict):
    """The resistance of one joint and its provenance.

    Attributes:
        model: any hysteresis model, in the file as its `to_dict`.
        samples: other models that the data also allow, to randomize with.
        range: angles [rad] in which the model was identified or is meant to be used.
        start_angle: where the memory begins [rad].
        start_torque: the resistance there [N·m].
        grade: published (printed in a paper), identified (fitted to curves) or assumed.
        source: where the numbers come from, in words.
        data_sha256: hash of the curve file, if identified.
        fit_nrmse: NRMSE on the fitted curves, if identified.
        certificate_margin: the model's certificate margin when the file was made.
    """

    model: Model
    samples: tuple[Model, ...] = ()
    range: tuple[FiniteFloat, FiniteFloat]
    start_angle: FiniteFloat
    start_torque: FiniteFloat = 0.0
    grade: Grade
    source: str
    data_sha256: str | None = None
    fit_nrmse: FiniteFloat | None = None
    certificate_margin: FiniteFloat | None = None

    @model_validator(mode="after")
    def _angles_are_radians(self) -> "SuitJoint":
        if not self.range[0] < self.range[1]:
            raise ValueError(
                f"range is {list(self.range)}: the first angle must be the smaller one"
            )
        if max(map(abs, (*self.range, self.start_angle))) > 2 * math.pi:
            raise ValueError(
                f"range is {list(self.range)} and start_angle {self.start_angle}: more than a full "
                "turn; both are radians"
            )
        return self

    @model_validator(mode="after")
    def _samples_are_as_safe(self) -> "SuitJoint":
        for i, sample in enumerate(self.samples):
            if _is_safe(self.model) and not _is_safe(sample):
                raise ValueError(
                    f"samples[{i}] has certificate margin {sample.certificate().margin:.3g}, but "
                    "the model itself is certified: remove that sample"
                )
        return self

    def scaled(self, *, torque: float) -> "SuitJoint":
        """Returns the joint with `torque` times the resistance, as its source then says.

        Raises:
            InputError: `torque` is not finite or not above 0.
        """
        model = self.model.scaled(torque=torque)
        changes = {
            "model": model,
            "samples": tuple(sample.scaled(torque=torque) for sample in self.samples),
            "start_torque": torque * self.start_torque,
            "certificate_margin": self.certificate_margin and model.certificate().margin,
            "source": f"{self.source}; then {torque:.3g} times that torque",
        }
        return SuitJoint(**(dict(self) | changes))


class Suit(_Strict):
    """A suit: hysteresis models by joint. Joints that are not listed move freely.

    Attributes:
        schema_version: version of this file format.
        name: what it is called.
        description: what it is, including how far to trust it.
        label: "from paper" (its numbers come from published ones), "illustrative" (of a plausible
            size, but no real suit's) or "extrapolated" (to another pressure); None for your own.
        pressure_kpa: operating pressure that its torques belong to [kPa], above 0 and at most 110;
            None if it is not known.
        joints: resistance by joint name.
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

    def at_pressure(self, pressure: float) -> "Suit":
        """Returns the suit at another operating pressure, to which its torques are proportional.

        They come from the gas that bending displaces (volume effect: Holschuh 2010, MIT). The
        fabric's own share is scaled too, though it would stay.

        Args:
            pressure: of the suit [kPa], 0 to 110; at 0 no joint resists.

        Raises:
            InputError: the pressure is out of its range, or `pressure_kpa` is not known.
        """
        if not 0 <= pressure <= HIGHEST_PRESSURE:
            raise InputError(f"pressure is {pressure:g} kPa: give 0 to {HIGHEST_PRESSURE:g} kPa")
        if self.pressure_kpa is None:
            raise InputError(
                f"pressure is {pressure:g} kPa, but the suit {self.name!r} does not tell at which "
                "its torque was measured: add pressure_kpa to its file, or leave pressure out"
            )
        if pressure == self.pressure_kpa:
            return self
        factor = pressure / self.pressure_kpa
        return Suit(
            name=f"{self.name}-{pressure:g}kPa",
            description=f"{self.name} at {pressure:g} kPa: {factor:.3g} times its torque at "
            f"{self.pressure_kpa:g} kPa. {self.description}",
            label="extrapolated",
            pressure_kpa=pressure or None,
            joints={
                joint: entry.scaled(torque=factor)
                for joint, entry in self.joints.items()
                if factor > 0
            },
        )


def suit_names() -> list[str]:
    """Returns the names of the suits that ship with the package."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load_suit(name_or_path: str | os.PathLike[str]) -> Suit:
    """Reads a suit by the name of a shipped one, or from a JSON file.

    Raises:
        InputError: there is no such suit or file, or the file is not a valid suit.
    """
    text = os.fspath(name_or_path)
    is_path = text.endswith(".json") or Path(text).name != text
    path = Path(text) if is_path else FOLDER / f"{text}.json"
    if path.parent == FOLDER and not path.exists():
        error = unknown_name("suit", text, suit_names())
        raise InputError(f"{error}; or give the path of a .json file")
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a UTF-8 text file"
        raise InputError(f"cannot read the suit {str(path)!r}: {reason}") from error
    except json.JSONDecodeError as error:
        raise InputError(
            f"{path} is not complete JSON (line {error.lineno}: {error.msg}): restore or remake it"
        ) from error
    version = content.get("schema_version") if isinstance(content, dict) else None
    if version != SCHEMA_VERSION:
        raise InputError(
            f"{path}: schema_version is {version!r}, and this release reads {SCHEMA_VERSION}: "
            "remake it with `activesuit identify CURVES.csv --out DIR`"
        )
    try:
        return Suit.model_validate(content)
    except ValidationError as error:
        raise InputError(f"{path}: {_first(error)}") from error


def save_suit(suit: Suit, path: str | os.PathLike[str]) -> None:
    """Writes a suit file that `load_suit` reads back, in one piece."""
    write_text(path, suit.model_dump_json(indent=2, exclude_none=True) + "\n")


def _first(error: ValidationError) -> str:
    problem: Any = error.errors()[0]
    place = ".".join(str(part) for part in problem["loc"] if part != "[key]") or "the file"
    if problem["type"] == "extra_forbidden":
        return f"{place} is not a known field: remove it"
    if problem["type"] == "literal_error":
        return f"{place} is {problem['input']!r}: use {problem['ctx']['expected']}"
    if problem["type"] == "missing":
        return f"{place} is missing: add it"
    if problem["type"] == "value_error":  # ours, which names the value
        return f"{place}: {problem['ctx']['error']}"
    value = problem["input"]
    return f"{place}: {problem['msg']}" + (
        "" if isinstance(value, (dict, list)) else f" (it is {value!r})"
    )


def _is_safe(model: HysteresisModel) -> bool:
    certificate = model.certificate()
    return certificate.certified and certificate.dissipative
