"""The exception that a user's mistake raises, and the parts of its sentence."""

import difflib
from collections.abc import Iterable, Mapping
from typing import Any

LONGEST = 300  # characters of a message
LONGEST_VALUE = 80  # characters of a value in a message
GAP = " ... "


class InputError(ValueError):
    """A value that the user gave cannot be used: a file, an argument, a parameter or an action.

    The message is one sentence that names the value, the allowed range and the fix. The command
    line prints the message without a traceback and exits with code 2. The message is one line of at
    most 300 characters, without control characters. A longer message loses its middle, since the
    beginning names the mistake and the end gives the fix.

    Every public function raises this error for an argument that cannot be used, before anything has
    changed or been written. A docstring has a section "Raises" only for further errors.
    """

    def __init__(self, message: object = "") -> None:
        super().__init__(shortened(one_line(str(message)), LONGEST))


def unknown_name(
    kind: str, name: object, allowed: Iterable[str], elsewhere: Iterable[str] = ()
) -> InputError:
    """Returns the error for a name that is not in `allowed`, with the closest name as a hint.

    Names in the middle are left out where the message would be too long.

    Args:
        kind: Kind of the named thing, for the message ("suit").
        name: The unknown name.
        allowed: Known names.
        elsewhere: Known names in other places, as "place.name"; the hint has up to three of them
            where they are closer.
    """
    allowed = sorted(allowed)
    known = {path.rpartition(".")[2]: path for path in elsewhere} | {one: one for one in allowed}
    close = difflib.get_close_matches(str(name)[:LONGEST], known, n=3)
    if close and close[0] in allowed:
        close = close[:1]
    hint = f"; did you mean {' or '.join(repr(known[one]) for one in close)}?" if close else ""
    begin = f"unknown {kind} {shown(name)}: use one of "
    names, half = ", ".join(allowed), len(allowed) // 2
    while len(begin + names + hint) > LONGEST and half > 1:
        half -= 1
        names = ", ".join([*allowed[:half], "...", *allowed[-half:]])
    return InputError(begin + names + hint)


def install_line(extra: str) -> str:
    """Returns the command that installs an extra, in a clone of the repository: docs/install.md."""
    return f"pip install -e '.[{extra}]' -c constraints.txt"


def shown(value: Any) -> str:
    """Returns a value as an error message shows it: its repr, without the middle if it is long."""
    try:
        text = repr(value)
    except Exception:  # the value nests too deep, has too many digits, or its repr fails
        text = f"a {type(value).__name__}"
    return shortened(one_line(text), LONGEST_VALUE)


def shortened(text: str, longest: int) -> str:
    """Returns a text of at most `longest` characters, with a gap in its middle if it was longer."""
    if len(text) <= longest:
        return text
    end = (longest - len(GAP)) // 2
    return text[: longest - len(GAP) - end] + GAP + text[-end:]


def one_line(text: str) -> str:
    """Returns a text on one line, with every character that does not print as its escape."""
    line = " ".join(text.split("\n")) if "\n" in text else text
    if line.isprintable():
        return line
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in line)


def refuse_old_names(given: Iterable[str], renamed: Mapping[str, str]) -> None:
    """Refuses names of version 0.2."""
    for name in given:
        if name in renamed:
            raise InputError(f"{name!r} was a name of version 0.2: write {renamed[name]!r} instead")
