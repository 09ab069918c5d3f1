"""Reads and writes suit files as JSON, and lists the shipped ones."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..errors import InputError, shown, unknown_name
from ..json_files import read_json
from .suit_joints import SuitJoint, first_problem
from .suits import SCHEMA_VERSION, Suit

AnySuit = str | os.PathLike[str] | Suit | Mapping[str, Any]  # what `load_suit` takes

FOLDER = Path(__file__).parent / "suits"


def suit_names() -> list[str]:
    """Returns the names of the suits that ship with the package."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load_suit(suit: AnySuit) -> Suit:
    """Reads a shipped suit by its name, or any suit from a JSON file; or takes one as an object.

    Args:
        suit: Name of a shipped suit or path of a file; or a `Suit`, which is returned as it is; or
            `SuitJoint`s by the name of their joint; or the content of a suit file as a dict.

    Raises:
        InputError: There is no such suit or file, or its content is no valid suit.
    """
    if isinstance(suit, Suit):
        return suit
    if isinstance(suit, Mapping):
        return _of_mapping(suit)
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


def _of_mapping(given: Mapping[str, Any]) -> Suit:
    if not any(isinstance(value, SuitJoint) for value in given.values()):
        return _checked(dict(given), "suit")
    joints = {"name": "custom", "description": "Joints given as objects.", "joints": dict(given)}
    return _checked({"schema_version": SCHEMA_VERSION, **joints}, "suit")


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


def save_suit(suit: Suit, path: str | os.PathLike[str]) -> None:
    """Writes a suit file that `load_suit` reads back; the same as `suit.save(path)`."""
    suit.save(path)
