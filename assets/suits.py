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
    model_validator,
)

from ..errors import InputError, unknown_name
from ..files import write_text
from ..hysteresis import HysteresisModel, model_from_dict

SCHEMA_VERSION = 2
JOINTS = ("shoulder_abduction", "shoulder_flexion", "elbow_flexion", "wrist_flexion")
Grade = Literal["published", "identified", "assumed"]
GRADES: tuple[str, ...] = get_args(Grade)
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


class Suit(_Strict):
    """A suit: hysteresis models by joint. Joints that are not listed move freely.

    Attributes:
        schema_version: version of this file format.
        name: what it is called.
        description: what it is, including how far to trust it.
        joints: resistance by joint name.
    """

    schema_version: Literal[2] = SCHEMA_VERSION
    name: Annotated[str, Field(min_length=1)]
    description: str
    joints: dict[Literal[JOINTS], SuitJoint]  # type: ignore[valid-type]


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
