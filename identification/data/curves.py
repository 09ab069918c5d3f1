"""Measured angle-torque curves: one curve with its checks, and the curves of one joint."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, NamedTuple, get_args

import numpy as np

from ...arrays import Array
from ...checks import number
from ...errors import InputError
from ...hysteresis.loops import branches
from ...table_files import RADIANS_AT_MOST, time_goes_wrong

Role = Literal["fit", "predict"]
TORQUE_AT_MOST = 1e6  # N·m
RETURNED = 0.05  # shortest way back that counts, as a share of the span
ROUNDING = 1e-9  # angle [rad]: its product with the peak counts as no work
SURELY = -3.0  # standard deviations; noise alone is below in 1 of 700 cases


@dataclass(frozen=True, eq=False)
class Curve:
    """One measured motion of a joint.

    Attributes:
        angle: The joint angle in the order of measurement [rad], shape (n,), n >= 2.
        torque: The resistance, positive against positive motion [N·m], shape (n,).
        name: A label, unique in its file.
        role: "fit" for identification, "predict" for a curve that is kept to test the model.
        weight: Weight of the curve's squared errors in a fit, relative to other curves, > 0.
        time: The time of each sample [s], shape (n,), strictly increasing; None if unknown.
    """

    angle: Array
    torque: Array
    name: str
    role: Role = "fit"
    weight: float = 1.0
    time: Array | None = None

    def __post_init__(self) -> None:
        if [self.name.strip()] != self.name.splitlines() or self.name.startswith("#"):
            raise InputError(
                f"curve name {self.name!r}: use one line that neither begins with '#' nor begins "
                "or ends with a space"
            )
        for series in ("angle", "torque"):
            values = np.ascontiguousarray(getattr(self, series), dtype=np.float64)
            object.__setattr__(self, series, values)
        if self.angle.ndim != 1 or self.angle.shape != self.torque.shape:
            raise InputError(
                f"curve {self.name!r} has angles of shape {self.angle.shape} and torques of shape "
                f"{self.torque.shape}: give two series of equal length"
            )
        if self.angle.size < 2:
            raise InputError(
                f"curve {self.name!r} has {self.angle.size} sample: a curve needs at least 2"
            )
        if not (np.isfinite(self.angle).all() and np.isfinite(self.torque).all()):
            raise InputError(
                f"curve {self.name!r} has a value that is not finite: remove that sample"
            )
        if self.time is not None:
            self._check_time(np.ascontiguousarray(self.time, dtype=np.float64))
        if np.abs(self.angle).max() > RADIANS_AT_MOST:
            raise InputError(
                f"curve {self.name!r} reaches {np.abs(self.angle).max():.3g} rad, more than a full "
                "turn: give the angles in radians"
            )
        if np.abs(self.torque).max() > TORQUE_AT_MOST:
            raise InputError(
                f"curve {self.name!r} reaches {np.abs(self.torque).max():.3g} N·m, more than any "
                f"joint ({TORQUE_AT_MOST:g}): check the unit of the torque"
            )
        if np.ptp(self.angle) == 0:
            raise InputError(
                f"curve {self.name!r} stays at the angle {self.angle[0]:g} rad: without motion "
                "there is no hysteresis to identify"
            )
        if self.role not in get_args(Role):
            raise InputError(f"curve {self.name!r} has role {self.role!r}: use 'fit' or 'predict'")
        object.__setattr__(self, "weight", number(f"weight of curve {self.name!r}", self.weight))
        if self.weight <= 0:
            raise InputError(
                f"curve {self.name!r} has weight {self.weight:g}: give a number above 0, or the "
                "role 'predict' to keep it out of the fit"
            )

    def _check_time(self, time: Array) -> None:
        object.__setattr__(self, "time", time)
        if time.shape != self.angle.shape:
            raise InputError(
                f"curve {self.name!r} has times of shape {time.shape} and {self.angle.size} "
                "samples: give one time a sample, or None"
            )
        if not np.isfinite(time).all():
            raise InputError(f"curve {self.name!r} has a time that is not finite: repair it")
        back = np.flatnonzero(np.diff(time) <= 0)
        if back.size:
            at = int(back[0]) + 1
            fault = time_goes_wrong(time[at - 1], time[at])
            raise InputError(
                f"curve {self.name!r}: the time {fault} at sample {at}: put the samples in the "
                "order of measurement"
            )


class Lines(NamedTuple):
    """Where a curve was read: the name of a file, and the line of each sample."""

    file: str
    numbers: Sequence[int]


class Curves(list[Curve]):
    """The curves of one joint, and where they come from: a list that knows its roles.

    Attributes:
        source: The name of the file they were read from, or the names of several; empty if they
            were made in Python.
        sha256: The hash of that file's bytes, or of the hashes of several; None if there is none.
        lines: Where each curve was read, by its name; empty if there is no file.
        reading: A sentence for each file in another format than ours, on how the file was read.
    """

    def __init__(
        self,
        curves: Iterable[Curve] = (),
        *,
        source: str = "",
        sha256: str | None = None,
        lines: Mapping[str, Lines] | None = None,
        reading: Sequence[str] = (),
    ) -> None:
        """Makes the list; without a `source`, the source of given `Curves` stays."""
        super().__init__(curves)
        if isinstance(curves, Curves) and not source:
            source, sha256, lines = curves.source, curves.sha256, curves.lines
            reading = curves.reading
        self.source, self.sha256, self.lines = source, sha256, lines or {}
        self.reading = tuple(reading)

    def fitted(self) -> "Curves":
        """Returns the curves with role "fit"."""
        return self.of((one for one in self if one.role == "fit"), self.lines)

    def held_out(self) -> "Curves":
        """Returns the curves with role "predict", which test a model."""
        return self.of((one for one in self if one.role == "predict"), self.lines)

    @property
    def peak(self) -> float:
        """The largest |torque| of all curves [N·m]; 0 without curves."""
        return max((float(np.abs(curve.torque).max()) for curve in self), default=0.0)

    @property
    def angle_range(self) -> tuple[float, float]:
        """The smallest and the largest angle of all curves [rad]."""
        self._first()
        angle = np.concatenate([curve.angle for curve in self])
        return float(angle.min()), float(angle.max())

    def place(self, name: str, sample: int) -> str:
        """Returns the place of a sample of a curve in its file, in words."""
        if name in self.lines:
            where, several = self.lines[name], len({one.file for one in self.lines.values()}) > 1
            return f"line {where.numbers[sample]}{f' of {where.file}' if several else ''}"
        return f"sample {sample} of curve {name!r}"

    @property
    def names(self) -> list[str]:
        """The names of the curves."""
        return [curve.name for curve in self]

    @property
    def start_angle(self) -> float:
        """The angle at which the first curve begins [rad]."""
        return float(self._first().angle[0])

    @property
    def start_torque(self) -> float:
        """The mean torque with which the curves begin [N·m]."""
        self._first()
        return float(np.mean([curve.torque[0] for curve in self]))

    def _first(self) -> Curve:
        if not self:
            raise InputError("there is no curve: give at least one")
        return self[0]

    def of(self, curves: Iterable[Curve], lines: Mapping[str, Lines] | None = None) -> "Curves":
        """Returns curves made from these, of the same source, with the lines of their samples."""
        return Curves(
            curves, source=self.source, sha256=self.sha256, lines=lines, reading=self.reading
        )


def noise_floor(curves: Sequence[Curve]) -> float:
    """Estimates the standard deviation of the torque noise [N·m] from its second differences.

    The median makes it insensitive to the few samples at a reversal; smooth curves sampled densely
    contribute nothing.
    """
    second = np.concatenate([np.diff(curve.torque, 2) for curve in curves])
    return float(1.4826 * np.median(np.abs(second)) / np.sqrt(6)) if second.size else 0.0


def turns_back(curve: Curve) -> bool:
    """Returns whether a curve comes back by a good part of its range."""
    # The largest excursion, not the sum of steps: an encoder's jitter is no return.
    angle = curve.angle
    back = (np.maximum.accumulate(angle) - angle).max()
    forth = (angle - np.minimum.accumulate(angle)).max()
    return bool(min(forth, back) > RETURNED * np.ptp(curve.angle))


class LoopWork(NamedTuple):
    """Work of the closed parts of some curves, with deviations due to the noise of the torque."""

    work: float  # sum over all pairs of branches of the work in the range that both share [J]
    deviation: float  # standard deviation of the work [J]
    rise: float  # sum over all branches of change of torque times change of angle [J]
    rise_deviation: float  # standard deviation of the rise [J]

    @property
    def z(self) -> float:
        """The work over its deviation."""
        return self.work / self.deviation if self.deviation > 0 else math.copysign(9.9, self.work)

    @property
    def falls(self) -> bool:
        """Whether the torque surely falls where the angle rises, over all branches."""
        return self.rise < SURELY * self.rise_deviation


def loop_work(curves: Sequence[Curve]) -> LoopWork:
    """Returns the work that the loops of curves take, as far as branches overlap.

    Each branch makes a loop with the next one, in the angles that both pass. An offset of the
    torque takes no work.
    """
    work = variance = rise = ways = 0.0
    noise = noise_floor(curves)
    for curve in curves:
        if curve.angle.size < 3:
            continue
        pieces = branches(curve.angle, curve.torque)
        for one in pieces:
            way = float(np.ptp(one.angle[[0, -1]]))
            rise += way * one.direction * float(one.torque[-1] - one.torque[0])
            ways += 2 * way**2
        for one, other in pairwise(pieces):
            low = max(one.angle.min(), other.angle.min())
            high = min(one.angle.max(), other.angle.max())
            if high <= low:
                continue
            for piece in (one, other):
                order = np.argsort(piece.angle, kind="stable")
                grid = np.unique(np.clip(piece.angle, low, high))
                there = np.interp(grid, piece.angle[order], piece.torque[order])
                work += piece.direction * float(np.trapezoid(there, grid))
                variance += float(np.sum(np.gradient(grid) ** 2)) if grid.size > 1 else 0.0
    rounding = ROUNDING * Curves(curves).peak
    deviation, rise_deviation = (
        math.hypot(noise * math.sqrt(one), rounding) for one in (variance, ways)
    )
    return LoopWork(work, deviation, rise, rise_deviation)


def refuse_driven(curves: Sequence[Curve]) -> None:
    """Refuses curves whose torque surely has the wrong sign.

    Their loops give energy to the joint, and the torque falls where the angle rises. Loops that
    give energy alone are no mistake: a joint that begins far from rest gives back stored energy.
    """
    whole = ("the loops of the curves give", curves)
    for which, some in (whole, *((f"curve {one.name!r} gives", [one]) for one in curves)):
        found = loop_work(some)
        if found.z < SURELY and found.rise < 0:
            raise InputError(
                f"{which} back {-found.work:.3g} J more than taken ({-found.z:.1f} standard "
                "deviations), and the torque falls where the angle rises: it must be positive "
                "against positive motion, so change its sign"
            )
