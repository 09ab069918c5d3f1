"""The one exception that a user's mistake raises, and the hint that goes with a wrong name."""

import difflib
from collections.abc import Iterable
from numbers import Real


class InputError(ValueError):
    """Something the user gave cannot be used: a file, an argument, a parameter, an action.

    The message is one sentence that names the value, the allowed range and the fix. The command
    line prints it without a traceback and exits with code 2.
    """


def at_least(name: str, value: int, least: int) -> None:
    """Refuses a number below `least`.

    Raises:
        InputError: it is.
    """
    if value < least:
        raise InputError(f"{name} is {value}: use at least {least}")


def require(name: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Refuses what is no number from `low` to `high`.

    Raises:
        InputError: it is not.
    """
    if not (isinstance(value, Real) and low <= value <= high):
        raise InputError(f"{name} is {value!r}: use a number from {low:g} to {high:g}{unit}")


def require_flag(name: str, value: bool) -> None:
    """Refuses what is neither True nor False, as the text "no", which counts as true.

    Raises:
        InputError: it is.
    """
    if not isinstance(value, bool):
        raise InputError(f"{name} is {value!r}: use True or False")


def unknown_name(kind: str, name: str, allowed: Iterable[str]) -> InputError:
    """Returns the error for a name that is none of `allowed`, with the closest one as a hint."""
    allowed = sorted(allowed)
    close = difflib.get_close_matches(str(name), allowed, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return InputError(f"unknown {kind} {name!r}: use one of {', '.join(allowed)}{hint}")
