"""Reads the arguments of a command; a mistake in them is one sentence, like any other."""

import functools
import io
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr
from typing import Any

import tyro

from ..errors import InputError, shown

FRAME = " │╭╮╰╯"
ADVICE = ("Argument helptext", "For full helptext")  # parts of tyro's message that take many lines


def parsed(
    command: Callable[..., None], program: str, arguments: Sequence[str]
) -> Callable[[], None]:
    """Returns a call of the command with the arguments of a command line."""

    @functools.wraps(command)
    def later(*given: Any, **options: Any) -> Callable[[], None]:
        return functools.partial(command, *given, **options)

    said = io.StringIO()
    try:
        with redirect_stderr(said):
            return tyro.cli(
                later,
                prog=program,
                args=arguments,
                config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
            )
    except SystemExit as end:
        if not end.code:
            raise
        raise InputError(f"{_sentence(said.getvalue())}; see {program} --help") from None


def _sentence(box: str) -> str:
    """Returns what is wrong from the box that tyro draws: title, problem, hints and advice."""
    parts, part = [], []
    for line in box.splitlines()[1:]:
        text = line.strip(FRAME).strip()
        if text and not text.strip("─-"):  # a rule
            parts.append(" ".join(part).rstrip("."))
            part = []
        else:
            part.append(" ".join(text.split()))
    sentences = [one.strip() for one in parts if not one.startswith(ADVICE)]
    return "; ".join(one for one in sentences if one)


def named_values(option: str, given: Sequence[str]) -> dict[str, str]:
    """Returns the values of an option that is given as NAME=VALUE, by name."""
    found: dict[str, str] = {}
    for one in given:
        name, sign, value = one.partition("=")
        if not (sign and name and value):
            raise InputError(f"{option} has {shown(one)}: give NAME=VALUE")
        if name in found:
            raise InputError(f"{option} has {name!r} twice: give it once")
        found[name] = value
    return found
