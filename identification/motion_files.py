"""Motion files: the angles of one joint as CSV, read with every sample checked, and written."""

import csv
import io
import math
import os
from array import array
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import InputError
from ..files import content_of, write_text
from ..table_files import LARGEST, joint_angle, next_time, number_in, read_table

HEADER = "time_s,angle_rad"
ANGLES = ("angle_rad", "angle_deg")
TIMES = ("time_s", "time")


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

    Raises:
        InputError: The file is missing, has none of these columns, or contains anything but a
            motion; the message names the line.
    """
    path = Path(path)
    known = {*ANGLES, *TIMES, *([joint] if joint else [])}
    table = read_table(
        path,
        content_of(path, "motion", LARGEST, "thin it"),
        "motion",
        repr(HEADER),
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
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    if motion.time is None:
        writer.writerow(["angle_rad"])
        writer.writerows([f"{angle:.9f}"] for angle in motion.angle)
    else:
        writer.writerow(HEADER.split(","))
        for time, angle in zip(motion.time, motion.angle, strict=True):
            writer.writerow([f"{time:.12g}", f"{angle:.9f}"])
    write_text(path, text.getvalue())


def _one_of(header: list[str], names: list[str] | tuple[str, ...], path: Path) -> str:
    found = [column for column in header if column in names]
    if len(found) != 1:
        has = " and ".join(found) or f"none of the columns {', '.join(names)}"
        raise InputError(f"{path} has {has}: give exactly one of them")
    return found[0]
