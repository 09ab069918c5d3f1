"""report.json: what a command found, in sentences and tables, with its options and versions."""

import json
import platform
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from ... import __version__
from ...errors import InputError, shown
from ...json_files import read_json

CONTENTS = "report.json"
FORMAT = 1  # of report.json; a change that older pages cannot have gets the next number
PACKAGES = ("mujoco", "numpy", "scipy", "numba", "gymnasium")


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class KeptTable(_Part):
    """A table: its title, the names of its columns, and its rows."""

    title: str
    header: list[str]
    rows: list[list[str]]


class KeptMotion(_Part):
    """A motion whose time series is in the folder.

    Attributes:
        place: What was simulated: task, place and suit.
        policy: Name of the policy.
        file: Name of the CSV file with the time series.
        links: Place and axis of each joint in the frame of the link above [m], shape (4, 6).
        grip: Place of the grip in the frame of the hand [m], shape (3,).
        torso: Place of the torso in the world [m], shape (3,).
        turn: Rotation from the frame of the torso into the world, shape (3, 3).
    """

    place: str
    policy: str
    file: str
    links: list[list[float]]
    grip: list[float]
    torso: list[float]
    turn: list[list[float]]


class Contents(_Part):
    """What a report says beside its figures.

    Attributes:
        format: Number of the format of this file.
        command: Name of the command, as `SUBJECTS` has it.
        title: What the command was about: a file, or task, place and suit.
        answer: Sentences, the most important one first.
        tables: Tables.
        settings: Options of the run, by name.
        versions: Versions of the packages that the run used, by name.
        motions: Motions whose time series are in the folder.
    """

    format: int
    command: str
    title: str
    answer: list[str]
    tables: list[KeptTable]
    settings: dict[str, Any]
    versions: dict[str, str]
    motions: list[KeptMotion]


def contents(
    command: str,
    title: str,
    *,
    answer: Iterable[str],
    tables: Mapping[str, tuple[Sequence[str], Iterable[Sequence[str]]]],
    settings: Mapping[str, Any],
    motions: Iterable[dict[str, Any]],
) -> dict[str, Any]:
    """Returns what report.json holds, as plain values; see `Contents`."""
    return {
        "format": FORMAT,
        "command": command,
        "title": title,
        "answer": list(answer),
        "tables": [
            {"title": name, "header": list(header), "rows": [list(row) for row in rows]}
            for name, (header, rows) in tables.items()
        ],
        "settings": dict(settings),
        "versions": _versions(),
        "motions": list(motions),
    }


def read_contents(folder: Path) -> Contents:
    """Returns what the report of a run says."""
    path = folder / CONTENTS
    if not path.is_file():
        raise InputError(
            f"{str(folder)!r} has no {CONTENTS}: its run is of an older version or did not end; "
            "run the command again"
        )
    content = read_json(path, "contents of a report")
    found = content.get("format") if isinstance(content, dict) else None
    if found != FORMAT:
        raise InputError(
            f"{str(path)!r} has the format {shown(found)}, and this version reads {FORMAT}: run "
            "the command again"
        )
    try:
        return Contents.model_validate_json(json.dumps(content))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        raise InputError(
            f"{str(path)!r} has a wrong {place} ({first['msg']}): restore it, or run the command "
            "again"
        ) from error


def _versions() -> dict[str, str]:
    found = {"activesuit": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # a copy without metadata
            continue
    return found
