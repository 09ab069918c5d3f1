"""Corrections of measured curves, and terms that are fitted beside or before a model."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from scipy.optimize import minimize_scalar

from ...arrays import Array
from ...checks import number
from ...errors import InputError, unknown_name
from ...hysteresis.loops import reversals
from ..data.curves import Curve, Curves
from ..fits.registry import Fitted, Play, Rate
from .softening import Count, Softening, Softens, found_softening, without_change

TOLERANCE = 0.02  # largest distance of turns that are alike, over the angle's range
FEWEST = 2  # fewest cycles after the first of which a mean is taken
Tare = float | Literal["zero", "fit"]
FINE = 1e-3  # tolerance of a fitted offset, as a share of the peak
FLAT = 1.02  # ratio to the least error: where another offset fits as well, none is identifiable


def averaged_cycles(curves: Sequence[Curve]) -> Curves:
    """Returns records in which the mean of all later cycles follows the first one.

    The noise of that mean is smaller by the root of the number of cycles, and what changes from
    cycle to cycle is gone. The first cycle stays as measured: a model runs through it, so that its
    memory is right where the mean begins. Each branch is averaged at equal shares of its way;
    angles, torques and times are the means of those of the cycles.

    Args:
        curves: Records that go to and fro between two angles; first cycles need not be steady.

    Raises:
        InputError: A record has fewer than 3 cycles, or they do not turn at the same two angles.
    """
    family = Curves(curves)
    return family.of(map(_averaged, family))


def cycles_of(curve: Curve) -> int:
    """Returns how many cycles after the first `averaged_cycles` takes the mean of."""
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
    _refuse_uneven(curve, turns)
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


def _refuse_uneven(curve: Curve, turns: Sequence[int]) -> None:
    angles, near = curve.angle[list(turns)], TOLERANCE * float(np.ptp(curve.angle))
    for part in (angles[::2], angles[1::2]):
        if np.ptp(part) > near:
            raise InputError(
                f"curve {curve.name!r} turns between {part.min():.4g} and {part.max():.4g} rad on "
                f"one side: cycles that are averaged turn within {near:.2g} rad; leave "
                "average_cycles out"
            )


def _at_shares(branch: Array, share: Array) -> Array:
    """Returns angle, torque and time at shares of the way of a branch, shape (3, shares)."""
    angle = branch[0]
    way = np.maximum.accumulate((angle - angle[0]) * np.sign(angle[-1] - angle[0]))
    moved = np.concatenate([[True], np.diff(way) > 0])  # a dwell counts by its first sample
    return np.array([np.interp(share, way[moved] / way[-1], row[moved]) for row in branch])


def checked_tare(tare: Tare) -> None:
    """Checks the offset of a torque sensor."""
    if not isinstance(tare, str):
        number("tare", tare, "N·m")
    elif tare not in ("zero", "fit"):
        raise InputError(f"tare is {tare!r}: give a number in N·m, 'zero' or 'fit'")


def tared(curves: Curves, tare: float) -> Curves:
    """Returns curves less an offset of the torque sensor [N·m]."""
    if tare == 0:
        return curves
    rest = (replace(curve, torque=curve.torque - tare) for curve in curves)
    return curves.of(rest)


def found_tare(curves: Sequence[Curve], tare: Tare, error: Callable[[Curves], float]) -> float:
    """Returns the offset of the torque sensor [N·m].

    Args:
        curves: Curves to fit.
        tare: The offset; "zero" takes the mean torque with which the curves begin, "fit" the one
            that a fit of the model prefers.
        error: Function from curves to the error of the model fitted to them, over their peak.
    """
    family = Curves(curves)
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
    """Returns the root mean square error of a fit [N·m], or a large one where nothing fits."""
    try:
        return error(curves) * curves.peak
    except InputError:  # nothing certified fits such curves
        return 10 * curves.peak


@dataclass(frozen=True, kw_only=True)
class Corrections:
    """What a fit takes off the curves, or fits beside the model.

    Attributes:
        tare: Offset of the torque sensor [N·m], which is subtracted from all curves; "zero" is the
            mean torque with which they begin, "fit" the one that the certified fit prefers (of
            Jiles-Atherton where the model is selected).
        rate: Rate-dependent part of the torque that is fitted beside the certified model:
            nothing ("none"), a dashpot ("viscous"), or a dashpot and a Maxwell element
            ("relaxing"); the model is then `Viscoelastic`, and the curves need times.
        play: Whether the certified model is fitted behind a gap in the transmission ("fit"), at
            which contact opens at zero torque, or without one ("none"); the model is then
            `Backlash`, if a gap was found.
        softening: Whether a change of the torque over the cycles is estimated with the certified
            fit, as the tare is, and removed from the curves ("fit"), or there is none ("none").
            The model is then that of the end of the measurement.
        average_cycles: Whether all cycles of each record but the first are replaced by their mean,
            see `averaged_cycles`.
    """

    tare: Tare = 0.0
    rate: Rate = "none"
    play: Play = "none"
    softening: Softens = "none"
    average_cycles: bool = False

    def __post_init__(self) -> None:
        checked_tare(self.tare)
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
        """What is fitted beside or before the model, as options of `fit_model`."""
        return {
            name: value
            for name, value in (("rate", self.rate), ("play", self.play))
            if value != "none"
        }


class Corrected(NamedTuple):
    """Curves after the corrections.

    Attributes:
        family: All curves.
        measured: The curves to fit, perhaps thinned.
        tare: Offset that was subtracted [N·m].
        softening: Change over the cycles that was removed; None if none was.
        read: The curves as they were read.
    """

    family: Curves
    measured: Curves
    tare: float
    softening: Softening | None
    read: Curves


def averaged(curves: Curves, corrections: Corrections) -> Curves:
    """Returns the curves with averaged cycles where that is asked for."""
    return averaged_cycles(curves) if corrections.average_cycles else curves


def corrected(
    read: Curves,
    family: Curves,
    measured: Curves,
    corrections: Corrections,
    fitted: Callable[[Curves], Fitted],
) -> Corrected:
    """Returns the curves without tare and softening.

    Args:
        read: The curves as they were read.
        family: All curves.
        measured: The curves to fit.
        corrections: What to take off.
        fitted: Certified fit of the model to curves.
    """
    offset = found_tare(measured, corrections.tare, lambda curves: fitted(curves).loss)
    family, measured = tared(family, offset), tared(measured, offset)
    count, change = Count(family), None
    if corrections.softening == "fit":
        change = found_softening(measured, count, fitted)
    if change is not None:
        family, measured = (
            without_change(family, change, count),
            without_change(measured, change, count),
        )
    return Corrected(family, measured, offset, change, read)
