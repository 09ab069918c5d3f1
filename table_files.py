"""Reads tables of rigs, spreadsheets and programs: finds the dialect and checks the rows."""

import csv
import math
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from .errors import InputError, shown
from .units import is_unit

LARGEST = 256 * 2**20  # bytes; a million samples take 30 million
RADIANS_AT_MOST = 2 * math.pi  # no joint turns further; a larger "radian" is a degree
SEPARATORS = ("\t", ";", "|", ",", " ")  # in the order of precedence; " " is any white space
NAMES_OF_SEPARATORS = {"\t": "tabs", " ": "spaces", ";": "semicolons", "|": "bars"}
LONGEST_PREAMBLE = 300  # lines in which the header is searched
SAMPLED = 2000  # rows that show the decimal mark
COMMENT = ("#", "%")
NUMBER = re.compile(r"[+\-−]?(\d[\d.,]*|[.,]\d+)([eE][+-]?\d+)?")
GROUPED = {
    mark: re.compile(rf"[+\-−]?[1-9]\d{{0,2}}([{mark}]\d{{3}})+") for mark in ".,"
}  # thousands
NARROW = (("utf-8-sig", ""), ("cp1252", "Windows-1252"))  # encodings, and how they are named

Cells = list[str]
Lines = Sequence[tuple[int, str]]


class Table(NamedTuple):
    """A table in a file.

    Attributes:
        path: Path of the file.
        header: Names of the columns; "1", "2" and so on in a file without a header.
        units: Cells of a row of units below the header; empty without such a row.
        rows: Number of the line and cells of each row. Numbers have a decimal point.
        dialect: Phrases about differences from a comma-separated UTF-8 file that begins with its
            header.
    """

    path: Path
    header: Cells
    units: Cells
    rows: Iterator[tuple[int, Cells]]
    dialect: list[str]


def read_table(
    path: Path,
    content: bytes,
    what: str,
    expected: str,
    is_header: Callable[[Cells], bool] | None,
    decimal: str | None = None,
) -> Table:
    """Reads a table of cells that are separated by tabs, `;`, `|`, commas or spaces.

    Lines before the header are left out, as are empty lines below the header and lines that begin
    with `#` or `%`. Rows are made one by one, since a million rows together take a gigabyte.

    Args:
        path: Path of the file, for messages.
        content: Content of the file.
        what: Name of the content, for messages ("curves").
        expected: Known headers, as a phrase for messages.
        is_header: Function that recognizes the header by its cells; None for a file without header.
        decimal: Decimal mark, "." or ","; by default the mark that the numbers show.
    """
    if decimal not in (None, ".", ","):
        raise InputError(f"decimal is {shown(decimal)}: give '.' or ','")
    text, encoding = _decoded(path, content, what)
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if line.strip()]
    if is_header is None:
        at, separator, header = _without_header(path, lines)
    else:
        at, separator, header = _header(path, lines, is_header, expected)
    data = [one for one in lines[at:] if not one[1].lstrip().startswith(COMMENT)]
    units: Cells = []
    if data and is_header is not None:
        first = _cells(path, *data[0], separator)
        if any(map(is_unit, first)) and not any(map(NUMBER.fullmatch, first)):
            units, data = first, data[1:]
    mark = decimal or _decimal_mark(path, data, separator)
    before = sum(not line.startswith(COMMENT) for _, line in lines[: max(at - 1, 0)])
    dialect = [encoding] if encoding else []
    dialect += [f"text before the header left out ({before} lines)"] if before else []
    if separator != ",":
        dialect.append(f"{NAMES_OF_SEPARATORS[separator]} between cells")
    dialect += ["decimal commas"] if mark == "," else []
    return Table(path, header, units, _rows(path, data, separator, mark, len(header)), dialect)


def number_in(text: str, column: str, path: Path, line: int) -> float:
    """Returns the finite number in a cell; raises an InputError if there is none."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{path}, line {line}: {column} is {shown(text)}: give a finite number")
    return value


def next_time(time: float, before: Sequence[float], path: Path, line: int) -> float:
    """Returns the time of a row [s]; raises an InputError unless time has passed since `before`."""
    if before and time <= before[-1]:
        raise InputError(
            f"{path}, line {line}: the time {time_goes_wrong(before[-1], time)}: put the samples "
            "in the order of measurement"
        )
    return time


def joint_angle(angle: float, column: str, hint: str, path: Path, line: int) -> float:
    """Returns an angle [rad]; refuses, with a hint, an angle that no joint reaches."""
    if abs(angle) > RADIANS_AT_MOST:
        raise InputError(
            f"{path}, line {line}: {column} is {angle:.6g} rad, more than a full turn: {hint}"
        )
    return angle


def time_goes_wrong(before: float, after: float) -> str:
    """Returns a phrase for the wrong step of time between two samples [s]."""
    if after == before:
        return f"stands still at {after:.12g} s"
    return f"runs back from {before:.12g} to {after:.12g} s"


def _decoded(path: Path, content: bytes, what: str) -> tuple[str, str]:
    """Returns the text of a file, and its encoding if that is not UTF-8."""
    wide = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    for encoding, name in (("utf-16", "UTF-16"),) if wide else NARROW:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text, name
    raise InputError(f"cannot read the {what} {shown(str(path))}: not a text file")


def _header(
    path: Path, lines: Lines, is_header: Callable[[Cells], bool], expected: str
) -> tuple[int, str, Cells]:
    """Returns the index of the line below the header, the separator, and the header."""
    for separator, at, cells in _first_rows(path, lines, "#% "):
        if is_header(cells):
            return at + 1, separator, cells
    if all(line.lstrip().startswith(COMMENT) for _, line in lines):
        raise InputError(f"{path} is empty: give a header {expected} and samples")
    at, separator, _ = _without_header(path, lines)
    above = _cells(path, *lines[at - 1], separator) if at else []
    known = f"the columns {', '.join(map(repr, above))}" if above else "no header"
    raise InputError(f"{path} has {known}: use the header {expected}")


def _without_header(path: Path, lines: Lines) -> tuple[int, str, Cells]:
    """Returns the index of the first line of numbers, the separator, and numbers as header."""
    for separator, at, cells in _first_rows(path, lines):
        if sum(NUMBER.fullmatch(cell) is not None for cell in cells) >= 2:
            return at, separator, [str(i + 1) for i in range(len(cells))]
    first = lines[0][1].strip() if lines else ""
    raise InputError(
        f"{path} has no line with two numbers, and begins with {shown(first)}: give a table"
    )


def _first_rows(path: Path, lines: Lines, marks: str = "") -> Iterator[tuple[str, int, Cells]]:
    """Yields separator, index and cells of the first lines, without marks before the cells."""
    for separator in SEPARATORS:
        for at, (number, line) in enumerate(lines[:LONGEST_PREAMBLE]):
            with suppress(InputError):  # text before the table
                yield separator, at, _cells(path, number, line.lstrip(marks), separator)


def _cells(path: Path, number: int, line: str, separator: str) -> Cells:
    """Returns the cells of a line; a unit in brackets behind a space belongs to the word before."""
    if separator == " ":
        return [word.replace("\0", " ") for word in re.sub(r"\s+(?=[\[(])", "\0", line).split()]
    try:
        row = next(csv.reader([line], delimiter=separator, strict=True))
    except csv.Error as error:
        raise InputError(f"{path}, line {number}: not a CSV file ({error})") from error
    return [cell.strip() for cell in row]


def _decimal_mark(path: Path, data: Lines, separator: str) -> str:
    """Returns the decimal mark that the first rows show."""
    unclear = ""
    for number, line in data[:SAMPLED]:
        for cell in _cells(path, number, line, separator):
            if "," not in cell or not NUMBER.fullmatch(cell):
                continue
            if "." in cell:
                return max(".,", key=cell.rindex)
            if not GROUPED[","].fullmatch(cell):
                return ","
            unclear = unclear or f"{path}, line {number}: {cell!r}"
    if unclear:
        raise InputError(
            f"{unclear} has either thousands or decimals behind the comma: say which by "
            "decimal '.' or ','"
        )
    return "."


def _rows(
    path: Path, data: Lines, separator: str, decimal: str, width: int
) -> Iterator[tuple[int, Cells]]:
    other = "." if decimal == "," else ","
    for number, line in data:
        cells = _cells(path, number, line, separator)
        if len(cells) == width + 1 and not cells[-1]:
            cells.pop()  # a separator at the end of the line
        if len(cells) != width:
            both = separator == "," and len(cells) > width
            hint = "; a comma cannot be both separator and decimal mark" if both else ""
            raise InputError(
                f"{path}, line {number}: {len(cells)} cells where the header has {width}{hint}"
            )
        if decimal == "," or "−" in line or (other in line and (separator != "," or '"' in line)):
            cells = [_with_point(cell, decimal, path, number) for cell in cells]
        yield number, cells


def _with_point(cell: str, decimal: str, path: Path, line: int) -> str:
    """Returns a number with a decimal point, without marks of thousands; other text unchanged."""
    if not NUMBER.fullmatch(cell):
        return cell
    other = "." if decimal == "," else ","
    whole = cell.split(decimal, maxsplit=1)[0]
    if cell.count(decimal) > 1 or (other in cell and not GROUPED[other].fullmatch(whole)):
        raise InputError(
            f"{path}, line {line}: {cell!r} is no number with the decimal mark {decimal!r}, which "
            "other numbers have: repair it, or say which mark is right by decimal '.' or ','"
        )
    return whole.replace(other, "").replace("−", "-") + cell[len(whole) :].replace(decimal, ".")
