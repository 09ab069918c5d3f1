"""Rows and cells of the CSV files that a user measures, each mistake named with its line."""

import csv
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from .errors import InputError, shown

LARGEST = 256 * 2**20  # bytes; a million samples take 30 million
RADIANS_AT_MOST = 2 * math.pi  # no joint turns further; a larger "radian" is a degree


def rows_of(path: Path, content: bytes, what: str, header: str) -> Iterator[tuple[int, list[str]]]:
    """Yields line number and cells of every line that is neither empty nor a comment, at least one.

    They are made one by one, since those of a million lines together take a gigabyte.

    Raises:
        InputError: It is no CSV file, or has no such line.
    """
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(
            f"cannot read the {what} {shown(str(path))}: not a UTF-8 text file"
        ) from error
    empty = True
    for number, line in enumerate(lines, start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            yield number, next(csv.reader([line], strict=True))
        except csv.Error as error:
            raise InputError(f"{path}, line {number}: not a CSV file ({error})") from error
        empty = False
    if empty:
        raise InputError(f"{path} is empty: give a header {header!r} and samples")


def number_in(cells: dict[str, str], column: str, path: Path, line: int) -> float:
    """Returns the finite number in a cell; raises an InputError if there is none."""
    try:
        value = float(cells[column])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"{path}, line {line}: {column} is {shown(cells[column])}: give a finite number"
        )
    return value


def next_time(
    cells: dict[str, str], column: str, before: Sequence[float], path: Path, line: int
) -> float:
    """Returns the time of a row [s], which must be after those of the rows before it.

    Raises:
        InputError: It is no finite number, or not after them.
    """
    time = number_in(cells, column, path, line)
    if before and time <= before[-1]:
        raise InputError(
            f"{path}, line {line}: the time {time_goes_wrong(before[-1], time)}: put the samples "
            "in the order of measurement"
        )
    return time


def angle_in(cells: dict[str, str], column: str, path: Path, line: int) -> float:
    """Returns the angle in a cell [rad]; raises an InputError if no joint turns that far."""
    value = number_in(cells, column, path, line)
    angle = math.radians(value) if column == "angle_deg" else value
    if abs(angle) > RADIANS_AT_MOST:
        hint = "no joint does that"
        if column != "angle_deg":
            in_degrees = "name the column angle_deg" if column == "angle_rad" else "give radians"
            hint = f"if these are degrees, {in_degrees}"
        raise InputError(
            f"{path}, line {line}: {column} is {value:g}, more than a full turn: {hint}"
        )
    return angle


def time_goes_wrong(before: float, after: float) -> str:
    """Returns a phrase for the wrong step of time between two samples [s]."""
    if after == before:
        return f"stands still at {after:.12g} s"
    return f"runs back from {before:.12g} to {after:.12g} s"
