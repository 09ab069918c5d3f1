"""Curve files: measured curves as CSV, read with every sample checked, and written."""

import csv
import hashlib
import io
import os
from array import array
from collections.abc import Sequence
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np

from ..csv_rows import LARGEST, RADIANS_AT_MOST, angle_in, next_time, number_in, rows_of
from ..errors import InputError
from ..files import content_of, write_text
from .curves import Curve, Curves


def load_curves(path: str | os.PathLike[str]) -> Curves:
    """Reads curves from a CSV file.

    The header is `curve,angle_rad,torque_nm` (or `angle_deg`), with optional columns `role`
    (`fit` or `predict`) and `weight` (> 0), which stay the same along a curve, and `time_s`, which
    rises along a curve or is empty for all of it. Rows of one curve are in the order of
    measurement. Empty lines and lines that begin with `#` are skipped.

    Returns:
        The curves, with the name of the file and its hash.

    Raises:
        InputError: The file is missing or contains anything but usable curves; the message
            names the line.
    """
    path = Path(path)
    content = content_of(path, "curves", LARGEST, "thin it")
    rows = rows_of(path, content, "curves", "curve,angle_rad,torque_nm")
    _, header = next(rows)
    header = [name.strip() for name in header]
    angle_column = _angle_column(path, header)
    samples: dict[str, tuple[array, array, array]] = {}
    labels: dict[str, dict[str, Any]] = {}
    lines: dict[str, array] = {}
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
            label["weight"] = number_in(cells, "weight", path, line)
        for key, value in label.items():
            if labels.setdefault(name, label)[key] != value:
                raise InputError(
                    f"{path}, line {line}: curve {name!r} changes its {key} to {value!r}: give all "
                    "its samples the same"
                )
        angle, torque, time = samples.setdefault(name, (array("d"), array("d"), array("d")))
        if cells.get("time_s"):
            time.append(next_time(cells, "time_s", time, path, line))
        if len(time) != (len(angle) + 1 if time else 0):
            raise InputError(
                f"{path}, line {line}: curve {name!r} has a time at some samples only: fill the "
                "column time_s for all of them, or for none"
            )
        torque.append(number_in(cells, "torque_nm", path, line))
        try:
            angle.append(angle_in(cells, angle_column, path, line))
        except InputError as error:
            if max(map(abs, torque)) > RADIANS_AT_MOST:
                raise
            raise InputError(f"{error}; or the columns of angle and torque are exchanged") from None
        lines.setdefault(name, array("l")).append(line)
    if not samples:
        raise InputError(f"{path} has a header but no samples")
    try:
        curves = [
            Curve(
                np.array(angle),
                np.array(torque),
                name=name,
                time=np.array(time) if time else None,
                **labels[name],
            )
            for name, (angle, torque, time) in samples.items()
        ]
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    sha256 = hashlib.sha256(content).hexdigest()
    return Curves(curves, source=path.name, sha256=sha256, lines=lines)


def save_curves(
    path: str | os.PathLike[str], curves: Sequence[Curve], comments: Sequence[str] = ()
) -> None:
    """Writes curves so that `load_curves` reads them back.

    Angles are kept to 1e-6 rad and torques to 1e-6 N·m, or to 9 digits where all are below 1 N·m.

    There is a column `time_s` if any of them has its time.

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
    timed = any(curve.time is not None for curve in curves)
    optional = [*["weight"] * weighted, *["time_s"] * timed]
    writer.writerow(["curve", "role", *optional, "angle_rad", "torque_nm"])
    digits = ".6f" if Curves(curves).peak >= 1 else ".9g"
    for curve in curves:
        label = [curve.name, curve.role, *[curve.weight] * weighted]
        known = repeat(None) if curve.time is None else curve.time
        for time, angle, torque in zip(known, curve.angle, curve.torque, strict=False):
            now = ["" if time is None else f"{time:.15g}"] * timed
            writer.writerow([*label, *now, f"{angle:.6f}", f"{torque:{digits}}"])
    write_text(path, text.getvalue())


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
