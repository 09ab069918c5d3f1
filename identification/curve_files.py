"""Curve files: measured curves as CSV, read with every sample checked, and written."""

import csv
import hashlib
import io
import math
import os
from array import array
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError, shown
from ..files import write_text
from .curves import RADIANS_AT_MOST, Curve, Curves

LARGEST = 256 * 2**20  # bytes; a million samples take 30 million


def load_curves(path: str | os.PathLike[str]) -> Curves:
    """Reads curves from a CSV file.

    The header is `curve,angle_rad,torque_nm` (or `angle_deg`), with optional columns `role`
    (`fit` or `predict`) and `weight` (> 0), which stay the same along a curve. Rows of one curve
    are in the order of measurement. Empty lines and lines that begin with `#` are skipped.

    Returns:
        The curves, which remember the name of the file and its hash.

    Raises:
        InputError: The file is missing or holds anything that is not a usable curve; the message
            names the line.
    """
    path = Path(path)
    content = _bytes(path)
    rows = _rows(path, content)
    _, header = next(rows)
    header = [name.strip() for name in header]
    angle_column = _angle_column(path, header)
    samples: dict[str, tuple[array, array]] = {}
    labels: dict[str, dict[str, Any]] = {}
    for line, row in rows:
        if len(row) != len(header):
            raise InputError(
                f"{path}, line {line}: {len(row)} cells where the header has {len(header)}"
            )
        cells = dict(zip(header, (cell.strip() for cell in row), strict=True))
        name = cells["curve"]
        if not name:
            raise InputError(f"{path}, line {line}: the cell 'curve' is empty: name the curve")
        label: dict[str, Any] = {"role": cells.get("role", "fit")}
        if "weight" in cells:
            label["weight"] = _number(cells, "weight", path, line)
        for key, value in label.items():
            if labels.setdefault(name, label)[key] != value:
                raise InputError(
                    f"{path}, line {line}: curve {name!r} changes its {key} to {value!r}: give all "
                    "its samples the same"
                )
        angle, torque = samples.setdefault(name, (array("d"), array("d")))
        angle.append(_angle(cells, angle_column, path, line))
        torque.append(_number(cells, "torque_nm", path, line))
    if not samples:
        raise InputError(f"{path} has a header but no samples")
    try:
        curves = [
            Curve(np.array(angle), np.array(torque), name=name, **labels[name])
            for name, (angle, torque) in samples.items()
        ]
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return Curves(curves, source=path.name, sha256=hashlib.sha256(content).hexdigest())


def save_curves(
    path: str | os.PathLike[str], curves: Sequence[Curve], comments: Sequence[str] = ()
) -> None:
    """Writes curves so that `load_curves` reads them back (to 1e-6 rad and 1e-6 N·m).

    Raises:
        InputError: Two curves share a name, or the file cannot be written.
    """
    names = [curve.name for curve in curves]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two curves are named {name!r}: rename one of them")
    text = io.StringIO()
    lines = [line for comment in comments for line in comment.splitlines()]
    text.writelines(f"# {line}\n" for line in lines)
    writer = csv.writer(text, lineterminator="\n")
    weighted = any(curve.weight != 1 for curve in curves)
    writer.writerow(["curve", "role", *["weight"] * weighted, "angle_rad", "torque_nm"])
    for curve in curves:
        label = [curve.name, curve.role, *[curve.weight] * weighted]
        for angle, torque in zip(curve.angle, curve.torque, strict=True):
            writer.writerow([*label, f"{angle:.6f}", f"{torque:.6f}"])
    write_text(path, text.getvalue())


def _bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:  # a path may hold a zero byte
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"cannot read the curves {shown(str(path))}: {reason}") from error
    if len(content) > LARGEST:
        raise InputError(
            f"cannot read the curves {shown(str(path))}: it is longer than {LARGEST >> 20} MiB; "
            "thin them"
        )
    return content


def _rows(path: Path, content: bytes) -> Iterator[tuple[int, list[str]]]:
    """Yields line number and cells of every line that is neither empty nor a comment, at least one.

    They are made one by one, since those of a million lines together take a gigabyte.
    """
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(
            f"cannot read the curves {shown(str(path))}: not a UTF-8 text file"
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
        raise InputError(f"{path} is empty: give a header 'curve,angle_rad,torque_nm' and samples")


def _angle_column(path: Path, header: list[str]) -> str:
    """Checks the names of the columns; returns that of the angle."""
    for column in header:
        if header.count(column) > 1:
            raise InputError(f"{path} has the column {column!r} twice: keep one of them")
    if {"angle_deg", "angle_rad"} <= set(header):
        raise InputError(f"{path} has both angle_rad and angle_deg: keep one of them")
    angle_column = "angle_deg" if "angle_deg" in header else "angle_rad"
    for column in ("curve", angle_column, "torque_nm"):
        if column not in header:
            raise InputError(
                f"{path} has no column {column!r}: the header must be 'curve,angle_rad,torque_nm' "
                f"(or angle_deg), and it is {','.join(header)!r}"
            )
    return angle_column


def _number(cells: dict[str, str], column: str, path: Path, line: int) -> float:
    try:
        value = float(cells[column])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(
            f"{path}, line {line}: {column} is {shown(cells[column])}: give a finite number"
        )
    return value


def _angle(cells: dict[str, str], column: str, path: Path, line: int) -> float:
    value = _number(cells, column, path, line)
    angle = math.radians(value) if column == "angle_deg" else value
    if abs(angle) > RADIANS_AT_MOST:
        hint = "no joint does that"
        if column == "angle_rad":
            hint = "if these are degrees, name the column angle_deg"
        raise InputError(
            f"{path}, line {line}: {column} is {value:g}, more than a full turn: {hint}"
        )
    return angle
