"""Parts of curves: samples of a long record for a fit, and parts that are left out of a fit."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.loops import estimate_dead_band, reversals
from .curves import Curve, Curves

FITTED = 50_000  # approximate number of samples of all curves of a fit together
JUDGED = 5_000  # approximate number of samples of a verdict: more take long and add little
DRAWN = 4_000  # approximate number of points of all curves of a panel together
LEAST_KNOWN = 1 / 3  # least share of a record in the first fit
LEAST_TURNS = 3  # least number of reversals in the last two thirds of a record
BLOCKS = 3  # largest number of parts of a record that are left out
BEYOND = 0.01  # tolerated excursion of a part beyond the known range, over that range


def thinned(curves: Sequence[Curve], most: int = FITTED) -> Curves:
    """Returns curves of about `most` samples in all: the given curves, unless they have more.

    Of each curve every n-th sample stays, with its two ends and its turning points; n is the number
    of samples over `most`, rounded up. Samples are left as they are, noise included.
    """
    every = _step(curves, most)
    if every == 1:
        return Curves(curves)
    family = Curves(curves)
    short = (picked(curve, kept_samples(curve.angle, every)) for curve in family)
    return family.of(short)


def drawn_samples(curves: Sequence[Curve], most: int = DRAWN) -> list[NDArray[np.intp]]:
    """Returns the indices of the samples to draw of each curve of a panel, about `most` in all."""
    every = _step(curves, most)
    return [kept_samples(curve.angle, every) for curve in curves]


def drawn_note(curves: Sequence[Curve]) -> str:
    """Returns how many samples of a panel's curves are drawn, in words; empty if all are."""
    drawn = sum(indices.size for indices in drawn_samples(curves))
    total = _samples(curves)
    return f"{drawn:,} of {total:,} samples drawn" if drawn < total else ""


def kept_samples(angle: Array, every: int) -> NDArray[np.intp]:
    """Returns the indices of every n-th sample, of both ends and of the turning points.

    There are never more turning points than other samples: the smallest swings of a curve that
    turns more often count as noise.
    """
    if every == 1:
        return np.arange(angle.size)
    regular = np.append(np.arange(0, angle.size - 1, every), angle.size - 1)
    dead_band = estimate_dead_band(angle)
    turns = reversals(angle, dead_band)
    while turns.size > regular.size:
        dead_band = 2 * dead_band if dead_band > 0 else 1e-6 * float(np.ptp(angle))
        turns = reversals(angle, dead_band)
    return np.union1d(regular, turns)


def picked(curve: Curve, indices: NDArray[np.intp] | slice) -> Curve:
    """Returns a curve of some samples of another."""
    time = None if curve.time is None else curve.time[indices]
    return replace(curve, angle=curve.angle[indices], torque=curve.torque[indices], time=time)


def _step(curves: Sequence[Curve], most: int) -> int:
    return max(1, -(-_samples(curves) // most))


def _samples(curves: Sequence[Curve]) -> int:
    return sum(curve.angle.size for curve in curves)


class Question(NamedTuple):
    """A part of the curves that a fit to the others has to predict."""

    known: list[Curve]  # to fit
    curve: Curve  # along which the model runs, from its beginning
    asked: slice  # samples of the curve on which the prediction is judged

    @property
    def beyond(self) -> bool:
        """Whether the asked part has angles outside the range of the known curves."""
        known = np.concatenate([one.angle for one in self.known])
        return not _covers(known, self.curve.angle[self.asked])

    def errors(self, torque: Array) -> Array:
        """Returns predicted less measured torque [N·m], given the torque along the curve."""
        return (torque - self.curve.torque)[self.asked]


def questions(curves: Sequence[Curve]) -> list[Question]:
    """Returns the parts of curves to leave out, one after the other.

    Of several curves each is left out in turn, except the curve that reaches farthest: no other
    curve determines a model of many weights there, and the error of such an extrapolation would
    decide against a model that predicts well inside. Of one record the part after a reversal is
    left out; the model runs through all samples before, so that its memory is right there, and the
    next fit includes this part (a rolling origin, Tashman 2000, Int. J. Forecasting 16(4)). The
    known part has reached all angles of the left-out part, unless each cycle of the record is
    larger than the cycles before, as in structural tests: then predictions reach beyond.
    """
    if len(curves) > 1:
        reach = [float(np.abs(curve.angle - curve.angle[0]).max()) for curve in curves]
        farthest = int(np.argmax(reach))
        return [
            Question([*curves[:i], *curves[i + 1 :]], curve, slice(None))
            for i, curve in enumerate(curves)
            if i != farthest
        ]
    if not curves:
        raise InputError("there is no curve to fit: give at least one with role 'fit'")
    (record,) = curves
    first = LEAST_KNOWN * record.angle.size
    # The first part has turned back too.
    turns = [turn for turn in reversals(record.angle)[1:].tolist() if turn >= first]
    origins = [turn for turn in turns if _covers(record.angle[: turn + 1], record.angle[turn:])]
    if not origins and len(turns) < LEAST_TURNS:
        raise InputError(
            f"there is one curve with role 'fit', {record.name!r}, and no reversal in its last two "
            "thirds before which it has turned back and reached all angles that follow, nor three "
            "of them: a choice among models needs a record of several cycles, or 2 curves, better 3"
        )
    origins = origins or turns
    spread = np.unique(np.linspace(0, len(origins) - 1, BLOCKS).round().astype(int))
    chosen = [origins[i] for i in spread.tolist()]
    ends = [*chosen[1:], record.angle.size - 1]
    return [
        Question([picked(record, slice(begin + 1))], record, slice(begin + 1, end + 1))
        for begin, end in zip(chosen, ends, strict=True)
        if end > begin
    ]


def _covers(known: Array, asked: Array) -> bool:
    more = BEYOND * float(np.ptp(known))
    return bool(asked.min() >= known.min() - more and asked.max() <= known.max() + more)
