"""Corrections of measured curves before a fit, and terms that are fitted beside a model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from scipy.optimize import minimize_scalar

from ...arrays import Array
from ...checks import number
from ...errors import InputError, unknown_name
from ...hysteresis.loops import reversals
from ..data.curves import Curve, Curves, refuse_driven
from ..data.parts import JUDGED, thinned
from ..fits.registry import Fitted, Play, Rate
from .softening import Count, Softening, Softens, found_softening, without_change

Tare = float | Literal["zero", "fit"]
FINE = 1e-3  # tolerance of a fitted offset, as a share of the peak
FLAT = 1.02  # ratio to the least error, below which another offset fits as well: none is identified
TOLERANCE = 0.02  # largest distance of turns that are alike, over the angle's range
FEWEST = 2  # fewest cycles after the first of which a mean is taken


@dataclass(frozen=True, kw_only=True)
class Corrections:
    """Corrections of the curves before a fit, and terms that are fitted beside the model.

    Attributes:
        tare: Offset of the torque sensor [N·m], which is subtracted from all curves; "zero" is the
            mean torque at their beginning, "fit" the offset with the least error of the certified
            fit (of Jiles-Atherton if the model is selected).
        rate: Rate-dependent part of the torque that is fitted beside the certified model:
            nothing ("none"), a dashpot ("viscous"), or a dashpot and a Maxwell element
            ("relaxing"); the model is then `Viscoelastic`, and the curves need times.
        play: Whether the certified model is fitted behind a gap in the transmission ("fit"), at
            which contact opens at zero torque, or without one ("none"); the model is then
            `Backlash`, if a gap was found.
        softening: Whether a change of the torque over the cycles is estimated with the certified
            fit and removed from the curves ("fit"), so that the model is that of the end of the
            measurement, or not ("none").
        average_cycles: Whether `identify` replaces all cycles of each record but the first by their
            mean, see `averaged_cycles`.
    """

    tare: Tare = 0.0
    rate: Rate = "none"
    play: Play = "none"
    softening: Softens = "none"
    average_cycles: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.tare, str):
            number("tare", self.tare, "N·m")
        elif self.tare not in ("zero", "fit"):
            raise InputError(f"tare is {self.tare!r}: give a number in N·m, 'zero' or 'fit'")
        for name, known in (("rate", Rate), ("play", Play), ("softening", Softens)):
            given = getattr(self, name)
            if given not in get_args(known):
                raise unknown_name(name, given, get_args(known))
        if self.softening == "fit" and self.tare == "fit":
            raise InputError(
                "tare and softening are both 'fit': fit the tare first, and give it as a number"
            )
        if self.softening == "fit" and self.average_cycles:
            raise InputError("average_cycles hides what softening looks for: leave one of them out")

    @property
    def beside(self) -> dict[str, Any]:
        """Rate and play that are fitted with the model, as options of `fit_model`."""
        return {
            name: value
            for name, value in (("rate", self.rate), ("play", self.play))
            if value != "none"
        }


class Corrected(NamedTuple):
    """Curves after the corrections."""

    family: Curves  # all curves
    measured: Curves  # those to fit, thinned if they are long
    judged: Curves  # the same, thinned further for the verdict
    tare: float  # offset that was subtracted [N·m]
    softening: Softening | None  # change over the cycles that was removed, if there was one
    read: Curves  # the curves before the corrections


def corrected(
    read: Curves, corrections: Corrections, fitted: Callable[[Curves], Fitted]
) -> Corrected:
    """Returns curves without tare and softening; `fitted` is the certified fit of the model."""
    measured = thinned(read.fitted())
    refuse_driven(measured)
    offset = found_tare(measured, corrections.tare, lambda curves: fitted(curves).loss)
    family, measured = tared(read, offset), tared(measured, offset)
    count, change = Count(family), None
    if corrections.softening == "fit":
        change = found_softening(measured, count, fitted)
    if change is not None:
        family, measured = (
            without_change(family, change, count),
            without_change(measured, change, count),
        )
    judged = thinned(family.fitted(), JUDGED)
    return Corrected(family, measured, judged, offset, change, read)


def tared(curves: Curves, tare: float) -> Curves:
    """Returns curves less an offset of the torque sensor [N·m]."""
    if tare == 0:
        return curves
    rest = (replace(curve, torque=curve.torque - tare) for curve in curves)
    return curves.of(rest)


def found_tare(family: Curves, tare: Tare, error: Callable[[Curves], float]) -> float:
    """Returns the offset of the torque sensor [N·m].

    "zero" is the mean torque at the beginning of the curves, "fit" the offset with the least error
    of a fit; `error` returns the error of the fit of curves over their peak.
    """
    if tare == "zero":
        return family.start_torque
    if tare != "fit":
        return float(tare)
    peak = family.peak

    def misses(offset: float) -> float:
        return _misses(tared(family, offset), error)

    found: Any = minimize_scalar(
        misses, bounds=(-peak / 2, peak / 2), method="bounded", options={"xatol": FINE * peak}
    )
    best = float(found.x)
    if is_open(tared(family, best), error):
        raise InputError(
            "tare is 'fit', but the model fits these curves with any offset: leave it out, or "
            "give the offset as a number"
        )
    return best


def is_open(curves: Curves, error: Callable[[Curves], float]) -> bool:
    """Returns whether a model fits curves as well with another offset of a quarter of the peak."""
    return _misses(tared(curves, curves.peak / 4), error) < FLAT * _misses(curves, error)


def _misses(curves: Curves, error: Callable[[Curves], float]) -> float:
    """Returns the root mean square error of a fit [N·m], or a large number if no fit exists."""
    try:
        return error(curves) * curves.peak
    except InputError:  # nothing certified fits such curves
        return 10 * curves.peak


def averaged_cycles(curves: Sequence[Curve]) -> Curves:
    """Returns records in which the mean of all later cycles follows the first one.

    The noise of the mean is smaller by the root of the number of cycles, and changes from cycle to
    cycle are gone. The first cycle stays as measured: a model runs through this cycle, so that its
    memory is right where the mean begins. Each branch is averaged at equal shares of its way:
    angles, torques and times are means over the cycles. Records go to and fro between the same two
    angles at least three times; the first cycle need not be steady.
    """
    family = Curves(curves)
    return family.of(map(_averaged, family))


def cycles_of(curve: Curve) -> int:
    """Returns the number of cycles after the first, of which `averaged_cycles` takes the mean."""
    return max((len(_ends(curve)) - 1) // 2 - 1, 0)


def _averaged(curve: Curve) -> Curve:
    ends, count = _ends(curve), cycles_of(curve)
    if count < FEWEST:
        branches = reversals(curve.angle).size + 1
        raise InputError(
            f"curve {curve.name!r} has {branches} branches: an average needs at least "
            f"{2 * FEWEST + 2} between the same two angles, of which the first two are kept; "
            "measure more cycles, or leave average_cycles out"
        )
    turns = ends[2 : 3 + 2 * count]
    angles, near = curve.angle[turns], TOLERANCE * float(np.ptp(curve.angle))
    for part in (angles[::2], angles[1::2]):
        if np.ptp(part) > near:
            raise InputError(
                f"curve {curve.name!r} turns between {part.min():.4g} and {part.max():.4g} rad on "
                f"one side: cycles that are averaged turn within {near:.2g} rad; leave "
                "average_cycles out"
            )
    time = np.zeros_like(curve.angle) if curve.time is None else curve.time
    record = np.stack([curve.angle, curve.torque, time])
    rows = [record[:, : turns[0] + 1]]
    for phase in (0, 1):
        ways = [(turns[i], turns[i + 1]) for i in range(phase, 2 * count, 2)]
        size = round(np.median([end - begin for begin, end in ways]))
        share = np.linspace(0, 1, size + 1)
        branch = np.mean([_at_shares(record[:, b : e + 1], share) for b, e in ways], axis=0)
        branch[2] += rows[-1][2, -1] - branch[2, 0]
        rows.append(branch[:, 1:])
    angle, torque, time_s = np.concatenate(rows, axis=1)
    known = None if curve.time is None else time_s
    return replace(curve, angle=angle, torque=torque, time=known)


def _ends(curve: Curve) -> list[int]:
    """Returns the first sample, the reversals, and the last sample if it ends a whole branch."""
    ends = [0, *reversals(curve.angle).tolist(), curve.angle.size - 1]
    near = TOLERANCE * float(np.ptp(curve.angle))
    whole = len(ends) > 3 and abs(curve.angle[ends[-1]] - curve.angle[ends[-3]]) <= near
    return ends if whole else ends[:-1]


def _at_shares(branch: Array, share: Array) -> Array:
    """Returns angle, torque and time at shares of the way of a branch, shape (3, shares)."""
    angle = branch[0]
    way = np.maximum.accumulate((angle - angle[0]) * np.sign(angle[-1] - angle[0]))
    moved = np.concatenate([[True], np.diff(way) > 0])  # a dwell counts by its first sample
    return np.array([np.interp(share, way[moved] / way[-1], row[moved]) for row in branch])
