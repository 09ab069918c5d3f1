"""Reads and writes suit files as JSON, and lists the shipped ones."""

import json
import os
from pathlib import Path

from pydantic import ValidationError

from ..errors import InputError, unknown_name
from .suit_joints import first_problem
from .suits import SCHEMA_VERSION, Suit

FOLDER = Path(__file__).parent / "suits"


def suit_names() -> list[str]:
    """Returns the names of the suits that ship with the package."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def load_suit(name_or_path: str | os.PathLike[str]) -> Suit:
    """Reads a shipped suit by its name, or any suit from a JSON file.

    Raises:
        InputError: There is no such suit or file, or the file is not a valid suit.
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
        raise InputError(f"{path}: {first_problem(error)}") from error


def save_suit(suit: Suit, path: str | os.PathLike[str]) -> None:
    """Writes a suit file that `load_suit` reads back; the same as `suit.save(path)`."""
    suit.save(path)
