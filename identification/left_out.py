"""Parts of the curves that are left out of a fit, to test the predictions of the model."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import InputError
from ..hysteresis.loops import reversals
from .curves import Curve

LEAST_KNOWN = 1 / 3  # least share of a record in the first fit
LEAST_TURNS = 3  # fewer in the last two thirds of a record ask nothing
BLOCKS = 3  # largest number of parts of a record that are left out
BEYOND = 0.01  # tolerated excursion of a part beyond the known range, over that range


class Question(NamedTuple):
    """A part of the curves that a fit to the others has to predict.

    Attributes:
        known: Curves to fit.
        curve: Curve along which the model runs, from its beginning.
        asked: Samples of it on which the prediction is judged.
    """

    known: list[Curve]
    curve: Curve
    asked: slice

    @property
    def beyond(self) -> bool:
        """Whether the part has angles that the known curves have not reached."""
        known = np.concatenate([one.angle for one in self.known])
        return not _covers(known, self.curve.angle[self.asked])

    def errors(self, torque: Array) -> Array:
        """Returns predicted less measured torque [N·m], given the torque along the curve."""
        return (torque - self.curve.torque)[self.asked]


def questions(curves: Sequence[Curve]) -> list[Question]:
    """Returns the parts of curves to leave out, one after the other.

    Of several curves each is left out in turn, except the one that reaches farthest: no other curve
    determines a model of many weights there, and the score of such an extrapolation would decide
    against it, however well it predicts inside. Of one record the end is left out, from a reversal
    on; the model runs through all samples before, so that its memory is right there, and the next
    fit includes that part too (a rolling origin, Tashman 2000, Int. J. Forecasting 16(4)). Here too
    the known part has reached all angles of the left-out one, unless each cycle of the record is
    larger than those before, as in protocols of structural tests: then predictions reach beyond it.
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
        Question([_until(record, begin)], record, slice(begin + 1, end + 1))
        for begin, end in zip(chosen, ends, strict=True)
        if end > begin
    ]


def _covers(known: Array, asked: Array) -> bool:
    more = BEYOND * float(np.ptp(known))
    return bool(asked.min() >= known.min() - more and asked.max() <= known.max() + more)


def _until(record: Curve, last: int) -> Curve:
    """Returns the beginning of a record, up to a sample."""
    here = slice(last + 1)
    time = None if record.time is None else record.time[here]
    return replace(record, angle=record.angle[here], torque=record.torque[here], time=time)
