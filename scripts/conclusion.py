"""The end of a command: its result is printed, and written with a report into the run folder."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from .folders import RunFolder, to_json
from .output import table
from .text import say


def conclude(
    command: str,
    result: dict[str, Any],
    tables: Mapping[str, tuple[Sequence[str], Iterable[Sequence[str]]]],
    remarks: Iterable[str] = (),
    *,
    folder: RunFolder | None,
    json: bool,
    settings: Mapping[str, Any] | None = None,
    motions: Iterable[dict[str, Any]] = (),
) -> None:
    """Prints the result, as JSON or as tables and remarks; writes it and a report into a folder.

    Args:
        command: Name of the command, for the report.
        result: What result.json holds.
        tables: Header and rows of tables, by title.
        remarks: Sentences, the most important one first.
        folder: The run folder; None to write nothing.
        json: Whether to print JSON.
        settings: Options that the report shows; by default the plain values of the result.
        motions: Motions whose time series are in the folder, see `html.motions.kept_motion`.
    """
    tables = {title: (header, [*rows]) for title, (header, rows) in tables.items()}
    remarks = [*remarks]
    if folder:
        from .html.writing import write_report  # imports the simulation

        plain = {name: one for name, one in result.items() if not isinstance(one, (dict, list))}
        folder.json("result.json", result)
        write_report(
            *(folder, command, next(iter(tables))),
            answer=remarks,
            tables=tables,
            settings=plain if settings is None else settings,
            motions=motions,
        )
    if json:
        print(to_json(result))
        return
    for title, rows in tables.items():
        table(title, *rows)
    for remark in remarks:
        say(remark)
    if folder:
        say(f"wrote {folder.path}/result.json and report.html")
