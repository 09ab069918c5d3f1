"""`--set NAME=VALUE`: any option of an environment on the command line, by its name in Python."""

from collections.abc import Mapping, Sequence
from json import JSONDecodeError
from typing import Any

from ..checks import at_least
from ..envs.setup import OPTIONS
from ..errors import InputError, shown, unknown_name
from ..json_files import parse_json
from .parsing import named_values

LIMIT = "max_episode_steps"
SETTABLE = OPTIONS | {LIMIT}
_AS_IN_PYTHON = {"True": True, "False": False, "None": None}


def settings(given: Sequence[str]) -> dict[str, Any]:
    """Returns options of an environment, nested ones as dicts.

    Args:
        given: Options as NAME=VALUE, with a dot before the field of a nested one.

    Raises:
        InputError: An option is unknown or is there twice, or one has another form.
    """
    found: dict[str, Any] = {}
    for name, text in named_values("--set", given).items():
        *outer, last = name.split(".")
        if name.split(".")[0] not in SETTABLE:
            raise unknown_name("option of --set", name.split(".")[0], SETTABLE)
        place: Any = found
        for part in outer:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise InputError(f"--set has {part!r} as a value and with fields: give one of them")
        if last in place:
            raise InputError(f"--set has {name!r} as a value and with fields: give one of them")
        place[last] = value_of(name, text)
    if LIMIT in found:
        at_least(LIMIT, found[LIMIT], 1)
    return found


def value_of(name: str, text: str) -> Any:
    """Returns the value of an option: JSON, a list of words in brackets, or a word."""
    if text in _AS_IN_PYTHON:
        return _AS_IN_PYTHON[text]
    try:
        return parse_json(text, f"--set {name}")
    except InputError as error:
        if not isinstance(error.__cause__, JSONDecodeError):
            raise
    if text.startswith("[") and text.endswith("]"):
        return [value_of(name, word.strip()) for word in text[1:-1].split(",")]
    if text[0] in '{["':
        raise InputError(f"--set {name} is {shown(text)}: give JSON, or a list such as [1, 2]")
    return text


def joined(flags: Mapping[str, Any], others: Mapping[str, Any], of: str = "") -> dict[str, Any]:
    """Returns options that flags and `--set` give together.

    Args:
        flags: Options that flags give.
        others: Options that `--set` gives.
        of: Name of the option whose fields these are, with a dot.
    """
    found = dict(others)
    for name, value in flags.items():
        other = found.get(name, value)
        if isinstance(value, dict) and isinstance(other, dict):
            found[name] = joined(value, other, f"{of}{name}.")
        elif other != value:
            raise InputError(
                f"a flag gives {of}{name} {shown(value)}, and --set gives {shown(other)}: leave "
                "one of them out"
            )
        else:
            found[name] = value
    return found
