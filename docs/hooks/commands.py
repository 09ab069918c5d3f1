"""Puts the options of all commands into the page of commands while the site is built.

They are what `activesuit COMMAND --help` prints, so that the page is never older than the commands.
"""

import contextlib
import io
import os
import re
from collections.abc import Iterator
from typing import NamedTuple
from unittest.mock import patch

PAGE, MARK = "commands.md", "<!-- options of all commands -->"
NOTHING = re.compile(r" \(default: (None|False|)\)$")
SHARED = 5  # number of commands from which on an option is listed once for all


class Option(NamedTuple):
    """An option of a command: its group, how it is written, and what it does."""

    group: str
    written: str
    text: str


def on_page_markdown(markdown: str, page, **_: object) -> str:
    """Replaces the mark by a section for each command, and one for the shared options."""
    return markdown.replace(MARK, sections()) if page.file.src_uri == PAGE else markdown


def sections() -> str:
    """Returns the sections as Markdown."""
    from activesuit.scripts.main import COMMANDS

    helps = {name: _help(name) for name in COMMANDS}
    found = {name: list(_options(text)) for name, text in helps.items()}
    every = [option for options in found.values() for option in options]
    shared = [one for one in dict.fromkeys(every) if every.count(one) >= SHARED]
    parts = []
    for name, options in found.items():
        said = helps[name].partition("\n\n")[2].partition("\n ")[0].split("\n\n")
        parts += [f"### {name}", *(" ".join(one.split()) for one in said)]
        parts.append(_listed([one for one in options if one not in shared]))
        if any(one.group.startswith("wearer") for one in options):
            parts.append("It also takes [the options of the environment](#shared-options).")
    parts.append("### Shared options")
    for group in dict.fromkeys(one.group for one in shared):
        options = [one for one in shared if one.group == group]
        parts += [f"#### {group.capitalize()}", _listed(options)]
    return "\n\n".join(parts)


def _help(name: str) -> str:
    """Returns what a command prints as its help, in one column."""
    from activesuit.scripts.main import main

    with (
        patch.dict(os.environ, COLUMNS="80"),
        contextlib.redirect_stdout(io.StringIO()) as printed,
        contextlib.suppress(SystemExit),
    ):
        main([*name.split(), "--help"])
    return printed.getvalue()


def _options(text: str) -> Iterator[Option]:
    """Yields the options in a help, by how far each line is indented."""
    group, written, said = "", "", ""
    for line in [*text.splitlines(), ""]:
        head = re.match(r"  (\S.*?)(?:  +(.*))?$", line)
        if said and (head or not line.strip()):
            yield Option(group, written, NOTHING.sub("", " ".join(said.split())))
            written = said = ""
        if not line.strip(" -"):
            written = said = ""  # a rule below the title or the text of a group
        elif head:
            written, said = written + head[1].strip(), head[2] or ""
        elif line.startswith("      "):
            said += f" {line.strip()}"
        elif line.startswith(" "):
            group = line.strip()


def _listed(options: list[Option]) -> str:
    lines = (f"- `{one.written}`: {one.text}" for one in options if "--help" not in one.written)
    return "\n".join(lines)
