"""Files of measured curves and of motions: tables, read with every sample checked, and written."""

import csv
import hashlib
import io
import math
import os
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...files import content_of, write_text
from ...table_files import LARGEST, RADIANS_AT_MOST, joint_angle, next_time, number_in, read_table
from .columns import Column, Wanted, columns_of, described
from .curves import Curve, Curves, Lines

HEADER = (
    "'curve,angle_rad,torque_nm', or name the columns, as angle='Winkel [deg]', or angle=2 for the "
    "second one"
)
MOTION_HEADER = "time_s,angle_rad"
ANGLES = ("angle_rad", "angle_deg")
TIMES = ("time_s", "time")


def load_curves(
    *paths: str | os.PathLike[str],
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    decimal: str | None = None,
) -> Curves:
    """Reads curves from tables, as ActiveSuit, rigs, spreadsheets and dynamometers write them.

    The header of ActiveSuit is `curve,angle_rad,torque_nm` (or `angle_deg`), with optional columns
    `role` (`fit` or `predict`) and `weight` (> 0), which stay the same along a curve, and `time_s`,
    which rises along a curve or is empty for all of it. In other files the separator, the decimal
    mark, the columns by their usual names and the units in the header are found; `reading` of the
    result says what was found. A file without a column `curve` is one curve with the name of the
    file. Rows of one curve are in the order of measurement.

    Args:
        paths: One file or several.
        columns: Name in the header, or number from 1 on, of the column "angle", "torque", "time",
            "curve", "role" or "weight".
        units: Unit of "angle", "torque" or "time", which may be scaled, as "0.5 Nm/V".
        decimal: The decimal mark, "." or ",", where the numbers leave it open.

    Returns:
        The curves, with the names of the files and a hash of their contents.
    """
    if not paths:
        raise InputError("there is no file of curves: give at least one")
    wanted = Wanted(columns or {}, units or {})
    wanted.check()
    read = [_read(Path(path), wanted, decimal) for path in paths]
    if len(read) == 1:
        return read[0]
    names = [curve.name for family in read for curve in family]
    unique = len({*names}) == len(names)
    curves, lines = [], {}
    for family in read:
        for curve in family:
            name = curve.name if unique else f"{Path(family.source).stem} {curve.name}"
            if name in lines:
                raise InputError(f"two files are named {family.source!r}: rename one of them")
            curves.append(replace(curve, name=name))
            lines[name] = family.lines[curve.name]
    digests = "".join(str(family.sha256) for family in read)
    return Curves(
        curves,
        source=", ".join(family.source for family in read),
        sha256=hashlib.sha256(digests.encode()).hexdigest(),
        lines=lines,
        reading=[sentence for family in read for sentence in family.reading],
    )


def _read(path: Path, wanted: Wanted, decimal: str | None) -> Curves:
    """Reads the curves of one file."""
    content = content_of(path, "curves", LARGEST, "thin it")
    is_header = None if wanted.by_number else wanted.is_header
    table = read_table(path, content, "curves", HEADER, is_header, decimal)
    found = columns_of(table, wanted)
    samples, lines = _samples(path, table.rows, found)
    if not samples:
        raise InputError(f"{path} has a header but no samples")
    try:
        curves = [Curve(name=name, **fields) for name, fields in samples.items()]
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    done = [*described(table, found)]
    if done:
        family = Curves(curves)
        low, high = family.angle_range
        count = f"{len(family)} curves" if len(family) > 1 else "one curve"
        done.append(
            f"{count}, {sum(curve.angle.size for curve in family)} samples, {low:.3g} to {high:.3g}"
            f" rad, at most {family.peak:.3g} N·m"
        )
    return Curves(
        curves,
        source=path.name,
        sha256=hashlib.sha256(content).hexdigest(),
        lines={name: Lines(path.name, numbers) for name, numbers in lines.items()},
        reading=[f"{path.name}: {'; '.join(done)}"] if done else [],
    )


def _samples(
    path: Path, rows: Iterator[tuple[int, list[str]]], columns: Mapping[str, Column]
) -> tuple[dict[str, dict[str, Any]], dict[str, array]]:
    """Returns the fields of each curve, and the line of each of its samples."""
    samples: dict[str, tuple[array, array, array]] = {}
    labels: dict[str, dict[str, Any]] = {}
    lines: dict[str, array] = {}
    angles, torques, times = (columns.get(kind) for kind in ("angle", "torque", "time"))
    assert angles is not None and torques is not None
    for line, cells in rows:
        name = cells[columns["curve"].at] if "curve" in columns else path.stem
        if not name:
            raise InputError(f"{path}, line {line}: the cell 'curve' is empty: name the curve")
        label: dict[str, Any] = {}
        if "role" in columns:
            label["role"] = cells[columns["role"].at]
        if "weight" in columns:
            label["weight"] = number_in(cells[columns["weight"].at], "weight", path, line)
        for key, value in label.items():
            if labels.setdefault(name, label)[key] != value:
                raise InputError(
                    f"{path}, line {line}: curve {name!r} changes its {key} to {value!r}: give all "
                    "its samples the same"
                )
        angle, torque, time = samples.setdefault(name, (array("d"), array("d"), array("d")))
        if times is not None and cells[times.at]:
            now = _value(cells, times, path, line)
            time.append(next_time(now, time, path, line))
        if len(time) != (len(angle) + 1 if time else 0):
            raise InputError(
                f"{path}, line {line}: curve {name!r} has a time at some samples only: fill the "
                "column of the time for all of them, or for none"
            )
        torque.append(_value(cells, torques, path, line))
        now = _value(cells, angles, path, line)
        if abs(now) > RADIANS_AT_MOST:
            hint = "no joint does that"
            if angles.unit.factor == 1:
                hint = "if these are degrees, give the unit, as angle=deg, or name it angle_deg"
            if max(map(abs, torque)) <= RADIANS_AT_MOST:
                hint += "; or the columns of angle and torque are exchanged"
            joint_angle(now, angles.name, hint, path, line)
        angle.append(now)
        lines.setdefault(name, array("l")).append(line)
    fields = {
        name: {
            "angle": np.array(angle),
            "torque": np.array(torque),
            "time": np.array(time) if time else None,
            **labels.get(name, {}),
        }
        for name, (angle, torque, time) in samples.items()
    }
    return fields, lines


def _value(cells: list[str], column: Column, path: Path, line: int) -> float:
    """Returns the number in a column, in rad, N·m or s."""
    return column.unit.factor * number_in(cells[column.at], column.name, path, line)


def save_curves(
    path: str | os.PathLike[str], curves: Sequence[Curve], comments: Sequence[str] = ()
) -> None:
    """Writes curves so that `load_curves` reads them back.

    Angles are kept to 1e-6 rad and torques to 1e-6 N·m, or to 9 digits where all are below 1 N·m.
    There is a column `time_s` if any of them has its time.
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


class Motion(NamedTuple):
    """A motion of one joint: times [s], or None if unknown, and angles [rad], (n,) each."""

    time: Array | None
    angle: Array


def load_motion(path: str | os.PathLike[str], joint: str | None = None) -> Motion:
    """Reads the motion of one joint from a CSV file; columns of other names are left out.

    Args:
        path: Path of a file with the column `angle_rad` (or `angle_deg`), or one that has the name
            of the joint [rad], as the motions of tasks have; and with `time_s` (or `time`), which
            may be missing.
        joint: Name of the joint; None if the file has one joint only.
    """
    path = Path(path)
    known = {*ANGLES, *TIMES, *([joint] if joint else [])}
    table = read_table(
        path,
        content_of(path, "motion", LARGEST, "thin it"),
        "motion",
        repr(MOTION_HEADER),
        lambda cells: not known.isdisjoint(cells),
    )
    angle_column = _one_of(table.header, [*ANGLES, *([joint] if joint else [])], path)
    at = table.header.index(angle_column)
    times = [table.header.index(one) for one in TIMES if one in table.header]
    if len(times) > 1:
        _one_of(table.header, TIMES, path)
    in_degrees = angle_column == "angle_deg"
    hint = "no joint does that" if in_degrees else "if these are degrees, name it angle_deg"
    angle, time = array("d"), array("d")
    for line, cells in table.rows:
        value = number_in(cells[at], angle_column, path, line)
        value = math.radians(value) if in_degrees else value
        angle.append(joint_angle(value, angle_column, hint, path, line))
        for column in times:
            now = number_in(cells[column], table.header[column], path, line)
            time.append(next_time(now, time, path, line))
    if len(angle) < 2:
        raise InputError(f"{path} has {len(angle)} samples: a motion needs at least 2")
    if np.ptp(angle) == 0:
        raise InputError(f"{path} stays at the angle {angle[0]:g} rad: give a motion that moves")
    return Motion(np.array(time) if times else None, np.array(angle))


def save_motion(path: str | os.PathLike[str], motion: Motion) -> None:
    """Writes a motion so that `load_motion` reads it back (to 1e-9 rad)."""
    lines = [f"{angle:.9f}" for angle in motion.angle]
    if motion.time is not None:
        lines = [f"{time:.12g},{line}" for time, line in zip(motion.time, lines, strict=True)]
    header = MOTION_HEADER if motion.time is not None else "angle_rad"
    write_text(path, "\n".join([header, *lines, ""]))


def _one_of(header: list[str], names: list[str] | tuple[str, ...], path: Path) -> str:
    found = [column for column in header if column in names]
    if len(found) != 1:
        has = " and ".join(found) or f"none of the columns {', '.join(names)}"
        raise InputError(f"{path} has {has}: give exactly one of them")
    return found[0]
