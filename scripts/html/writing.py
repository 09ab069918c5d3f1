"""Writes the report of a run: report.json, what is said, and report.html, the page."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...errors import unknown_name
from ..folders import RunFolder
from .blocks import Section, Table
from .contents import CONTENTS, Contents, contents, read_contents
from .page import build, flat, hashes
from .subjects import SUBJECTS

PAGE = "report.html"


def write_report(
    folder: RunFolder,
    command: str,
    title: str,
    *,
    answer: Iterable[str],
    tables: Mapping[str, tuple[Sequence[str], Iterable[Sequence[str]]]],
    settings: Mapping[str, Any],
    motions: Iterable[dict[str, Any]] = (),
) -> None:
    """Writes report.json and report.html, after all other files of the run.

    Args:
        folder: The run folder.
        command: Name of the command, as `SUBJECTS` has it.
        title: What the command was about: a file, or task, place and suit.
        answer: Sentences, the most important one first.
        tables: Header and rows of tables, by title.
        settings: Options of the run, by name.
        motions: Motions whose time series are in the folder, see `motions.kept_motion`.
    """
    kept = contents(
        *(command, title), answer=answer, tables=tables, settings=settings, motions=motions
    )
    folder.json(CONTENTS, kept)
    folder.text(PAGE, report_page(folder.path))


def report_page(folder: Path) -> str:
    """Returns the page of a run, made from the files of its folder alone."""
    found = read_contents(folder)
    if found.command not in SUBJECTS:
        raise unknown_name("command", found.command, SUBJECTS)
    subject = SUBJECTS[found.command]
    sections = [
        Section(title="Answer", sentences=found.answer),
        *subject.sections(folder, found),
        *_tables(found),
        _origin(folder, found),
    ]
    version = found.versions.get("activesuit", "")
    lead = f"{found.title} · activesuit {subject.command} · version {version}"
    return build(folder, subject.heading, lead, sections)


def _tables(found: Contents) -> list[Section]:
    tables = [Table(title=one.title, header=one.header, rows=one.rows) for one in found.tables]
    return [Section(title="Tables", blocks=tables)] if tables else []


def _origin(folder: Path, found: Contents) -> Section:
    settings = Table(title="Options", header=["option", "value"], rows=flat(found.settings))
    versions = [[name, number] for name, number in found.versions.items()]
    return Section(
        title="Origin",
        sentences=["Everything on this page is from the files below, which are beside it."],
        blocks=[
            settings,
            Table(title="Versions", header=["package", "version"], rows=versions),
            Table(title="Files of data", header=["file", "SHA-256"], rows=hashes(folder)),
        ],
    )
