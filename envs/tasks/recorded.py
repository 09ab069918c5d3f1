"""Motions from a file: joint angles that somebody has recorded."""

import os
from array import array
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...errors import InputError, shown
from ...files import content_of
from ...table_files import LARGEST, joint_angle, next_time, number_in, read_table
from ..provenance import setting
from ..simulation.episode_plan import Motion
from .task import LONGEST, SHORTEST, Task

MOTION = ".csv"  # ending of the names of files of motions
HEADER = ("time", *JOINTS)
LARGEST_GAP = 3.0  # times the usual time between samples
IN_DEGREES = "if these are degrees, give radians"
LARGEST_STEP = 0.2  # [s], greatest time between samples at which a motion is known


@dataclass(frozen=True, kw_only=True)
class RecordedMotion(Task):
    """A motion from a CSV file with a header and the columns time [s] and four joint angles [rad].

    The columns are named as in `HEADER`, in any order; angles between samples are those of a cubic
    spline, at rest at both ends. The duration is that of the file unless it is given.

    Attributes:
        path: Path of the file.
    """

    path: str
    duration: float = setting(0.0, "s", SHORTEST, LONGEST)  # the duration of the file if 0

    source: ClassVar[str] = "a file of yours"
    _recorded: ClassVar[tuple[Array, Array]]

    def __post_init__(self) -> None:
        object.__setattr__(self, "_recorded", _read(self.path))
        if not self.duration:
            time = self._recorded[0]
            object.__setattr__(self, "duration", float(time[-1] - time[0]))
        super().__post_init__()

    def identity(self) -> dict[str, Any]:
        """Returns class, fields and a digest of the file's content, as plain values."""
        content = b"".join(part.tobytes() for part in self._recorded)
        return {**super().identity(), "content": sha256(content).hexdigest()[:16]}

    def motion(self, rng: np.random.Generator, samples: int, dt: float) -> Motion:
        """Returns the motion of the file; its last posture is kept to the end."""
        from scipy.interpolate import CubicSpline  # slow to import

        time, angle = self._recorded
        spline = CubicSpline(time - time[0], angle, bc_type="clamped")
        now = dt * np.arange(samples)
        inside = now <= spline.x[-1]
        found = [spline(np.minimum(now, spline.x[-1]), derivative) for derivative in range(3)]
        return found[0], found[1] * inside[:, None], found[2] * inside[:, None]


def _read(given: Any) -> tuple[Array, Array]:
    """Returns time [s] and angles [rad] of a file, shape (samples,) and (samples, 4)."""
    if not isinstance(given, str | os.PathLike):
        raise InputError(f"cannot read the motion {shown(given)}: give the path of a CSV file")
    path, time, angles = Path(given), array("d"), array("d")
    content = content_of(path, "motion", LARGEST, "thin it")
    header = ",".join(HEADER)
    table = read_table(path, content, "motion", repr(header), lambda cells: HEADER[0] in cells)
    if sorted(table.header) != sorted(HEADER):
        names = ", ".join(table.header)
        raise InputError(f"{path} has the columns {names}: use {', '.join(HEADER)}")
    columns = [(name, table.header.index(name)) for name in JOINTS]
    at = table.header.index(HEADER[0])
    for line, cells in table.rows:
        now = number_in(cells[at], HEADER[0], path, line)
        time.append(next_time(now, time, path, line))
        for name, column in columns:
            angle = number_in(cells[column], name, path, line)
            angles.append(joint_angle(angle, name, IN_DEGREES, path, line))
    if len(time) < 3:
        raise InputError(f"{path} has {len(time)} samples: a motion needs at least 3")
    return _checked(path, np.array(time), np.array(angles).reshape(-1, len(JOINTS)))


def _checked(path: Path, time: Array, angle: Array) -> tuple[Array, Array]:
    steps = np.diff(time)
    usual = float(np.median(steps))
    if steps.max() > min(LARGEST_GAP * usual, LARGEST_STEP):
        at = int(steps.argmax())
        raise InputError(
            f"{path} has a gap from {time[at]:g} to {time[at + 1]:g} s, where samples are usually "
            f"{usual:g} s apart: fill it; samples may be {LARGEST_STEP:g} s apart at most"
        )
    if not SHORTEST <= time[-1] - time[0] <= LONGEST:
        raise InputError(
            f"{path} lasts {time[-1] - time[0]:g} s: use {SHORTEST:g} to {LONGEST:g} s"
        )
    return time, angle
