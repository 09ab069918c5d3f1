"""What is left out of a fit, to see whether the model predicts it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import InputError
from ..hysteresis.loops import reversals
from .curves import Curve

LEAST_KNOWN = 1 / 3  # of a record, which the first fit knows
BLOCKS = 3  # of a record, at most
BEYOND = 0.01  # of the range that is known: a block may go so far beyond it


class Question(NamedTuple):
    """A part of the curves that a fit of the others shall predict.

    Attributes:
        known: Curves to fit.
        curve: Curve along which the model runs, from its beginning.
        asked: Which of its samples the prediction is judged by.
    """

    known: list[Curve]
    curve: Curve
    asked: slice

    def errors(self, torque: Array) -> Array:
        """Returns predicted less measured torque [N·m], given the torque along the curve."""
        return (torque - self.curve.torque)[self.asked]


def questions(curves: Sequence[Curve]) -> list[Question]:
    """Returns what is left out of curves, one part after the other.

    Of several curves each is left out in turn, but for the one that reaches farthest: no curve
    tells a model of many weights what lies beyond it, and a score of such a guess would decide
    against it whatever it does inside. Of one record the end is left out, from a reversal on; the
    model runs through all that comes before, so that its memory is right there, and the next fit
    knows that part too (a rolling origin, Tashman 2000, Int. J. Forecasting 16(4)). Here too the
    part that is known has reached all angles of what comes.

    Raises:
        InputError: There is no curve, or one record reaches its range at its end only.
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
    origins = [
        turn
        for turn in reversals(record.angle)[1:].tolist()  # the first part has turned back too
        if turn >= first and _covers(record.angle[: turn + 1], record.angle[turn:])
    ]
    if not origins:
        raise InputError(
            f"there is one curve with role 'fit', {record.name!r}, and no reversal in its last two "
            "thirds before which it has turned back and reached all angles that follow: a choice "
            "among models needs a record of several cycles, or 2 curves, better 3"
        )
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
