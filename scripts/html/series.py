"""Reads the columns of the CSV files that our own commands write."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...arrays import Array
from ...errors import InputError, shown
from ...files import content_of
from ...table_files import LARGEST, number_in


def read_columns(
    folder: Path, name: str, texts: Sequence[str], numbers: Sequence[str]
) -> tuple[dict[str, list[str]], dict[str, Array]]:
    """Returns columns of a CSV file of a run folder by their names, as texts and as numbers.

    An empty cell is a NaN among numbers.

    Args:
        folder: The run folder.
        name: Name of the file.
        texts: Names of columns of texts.
        numbers: Names of columns of numbers.
    """
    path = folder / name
    if Path(name).name != name or path.is_symlink():
        raise InputError(f"{shown(name)} is no file of the run folder {str(folder)!r}: restore it")
    content = content_of(path, "time series", LARGEST).decode("utf-8", errors="replace")
    try:
        header, *rows = csv.reader(io.StringIO(content)) if content else [[]]
    except csv.Error as error:
        raise InputError(f"{path} is no CSV file ({error}): run the command again") from error
    for column in (*texts, *numbers):
        if column not in header:
            raise InputError(f"{path} has no column {column!r}: run the command again")
    for line, row in enumerate(rows, 2):
        if len(row) != len(header):
            raise InputError(
                f"{path}, line {line}: {len(row)} cells below a header of {len(header)}: run the "
                "command again"
            )
    found = {column: [row[header.index(column)] for row in rows] for column in (*texts, *numbers)}
    if not rows:
        raise InputError(f"{path} has no rows: run the command again")
    return {column: found[column] for column in texts}, {
        column: np.array(
            [
                number_in(cell, column, path, line) if cell else np.nan
                for line, cell in enumerate(found[column], 2)
            ]
        )
        for column in numbers
    }
