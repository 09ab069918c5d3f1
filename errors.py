"""The exception that a user's mistake raises, and its sentence for an unknown name."""

import difflib
from collections.abc import Iterable


class InputError(ValueError):
    """A value that the user gave cannot be used: a file, an argument, a parameter or an action.

    The message is one sentence that names the value, the allowed range and the fix. The command
    line prints it without a traceback and exits with code 2.
    """


def unknown_name(kind: str, name: str, allowed: Iterable[str]) -> InputError:
    """Returns the error for a name that is not in `allowed`, with the closest name as a hint."""
    allowed = sorted(allowed)
    close = difflib.get_close_matches(str(name), allowed, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return InputError(f"unknown {kind} {name!r}: use one of {', '.join(allowed)}{hint}")
