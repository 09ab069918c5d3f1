"""Comparison of measured curves with an intended motion: range, reversals, rates and cycles.

A fit is tested by its curves only. Whether it is valid for another motion depends on how that
motion differs from them, which this module expresses in numbers.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.loops import estimate_dead_band, reversals
from ...hysteresis.protocol import finite_series
from ..data.curves import Curve
from ..data.files import Motion
from ..data.motions import BRANCHES
from .sentences import Remark, sentence

SMALLEST = 0.02  # assumed share of a motion's range: smaller swings do not count
DEEP = BRANCHES  # reversals within each other, as in `nested_motion`: more are not required
FINE = 1 / BRANCHES  # shortest required branch over the range, as in `nested_motion`
ENOUGH_CYCLES = 3  # assumed number: the third shows whether the change from the first continues
WHOLE = 0.9  # share of a motion's range: a branch of that length is half a cycle
BEYOND = 0.01  # tolerated excursion of a motion beyond the range of the curves, over that range
NEAR = 2.0  # assumed ratio to a measured rate or depth, up to which both are alike
PARTS = 10  # number of parts of a branch; the fastest part gives its rate
NESTED = 2  # least number of reversals within each other of a curve that tests nested loops


@dataclass(frozen=True, kw_only=True)
class Coverage:
    """Range, reversals, rates and cycles of motions of one joint.

    A branch is the way from one reversal to the next, or from or to an end of a motion. Swings
    below 2 % of a motion's range, or within its noise, count as none.

    Attributes:
        range: Smallest and largest angle [rad].
        reversals: Number of reversals of all motions.
        nesting: The most reversals that are remembered at once: 0 without reversals, 1 for
            first-order curves and cycles between two angles. By return-point memory (Madelung's
            rules) two reversals are forgotten when the motion passes the first of them, and all of
            them at an extreme of the whole motion so far.
        branches: The shortest, the median and the longest branch, as shares of the range.
        rates: Rate of the slowest and of the fastest branch [rad/s] of all motions with times,
            where the rate of a branch is the rate of the fastest of its ten parts; None without
            times.
        cycles: The most whole cycles of one motion: half the number of its branches over at least
            90 % of its range.
    """

    range: tuple[float, float]
    reversals: int
    nesting: int
    branches: tuple[float, float, float]
    rates: tuple[float, float] | None
    cycles: int

    @property
    def span(self) -> float:
        """Largest less smallest angle [rad]."""
        return self.range[1] - self.range[0]


def coverage(curves: Sequence[Curve]) -> Coverage:
    """Returns the coverage of measured curves."""
    return motion_coverage(Motion(curve.time, curve.angle) for curve in curves)


def motion_coverage(motions: Iterable[Motion]) -> Coverage:
    """Returns the coverage of motions of one joint."""
    given = [(time, finite_series("angle", angle, "rad")) for time, angle in motions]
    if not given:
        raise InputError("there is no motion: give at least one")
    low = min(float(angle.min()) for _, angle in given)
    high = max(float(angle.max()) for _, angle in given)
    if low == high:
        raise InputError(f"the motion stays at {low:g} rad: give one that moves")
    found = [_branches(time, angle) for time, angle in given if np.ptp(angle) > 0]
    ways = np.concatenate([one.ways for one in found]) / (high - low)
    rates = [rate for one in found for rate in one.rates]
    return Coverage(
        range=(low, high),
        reversals=sum(len(one.ways) - 1 for one in found),
        nesting=max(one.nesting for one in found),
        branches=(float(ways.min()), float(np.median(ways)), float(ways.max())),
        rates=(min(rates), max(rates)) if rates else None,
        cycles=max(one.cycles for one in found),
    )


def any_motion(measured: Coverage) -> Coverage:
    """Returns the coverage for any motion in the range and at the rates of the curves."""
    ways = (FINE, (FINE + 1) / 2, 1.0)
    return replace(measured, reversals=DEEP, nesting=DEEP, branches=ways)


def shortfalls(measured: Coverage, needed: Coverage) -> list[Remark]:
    """Returns a remark for each need of an intended motion that measured curves do not cover."""
    (least, most), (low, high) = measured.range, needed.range
    found, allowed, ends = [], BEYOND * measured.span, []
    if low < least - allowed:
        ends.append(sentence("range below", angle=least))
    if high > most + allowed:
        ends.append(sentence("range above", angle=most))
    if ends:
        values = {"low": low, "high": high, "least": least, "most": most}
        found.append(Remark("coverage range", values | {"ends": " and ".join(ends)}))
    if measured.nesting < min(needed.nesting, DEEP):
        why = sentence(f"nesting {min(measured.nesting, 2)}")
        values = {"deep": needed.nesting, "nesting": measured.nesting, "why": why}
        found.append(Remark("coverage nesting", values))
    shortest = measured.branches[0] * measured.span
    branch = needed.branches[0] * needed.span
    if NEAR * max(branch, FINE * measured.span) < shortest:
        found.append(Remark("coverage branches", {"needed": branch, "shortest": shortest}))
    if needed.rates and not measured.rates:
        found.append(Remark("coverage times", {"rate": needed.rates[1]}))
    elif needed.rates and measured.rates and needed.rates[1] > NEAR * measured.rates[1]:
        slowest, fastest = measured.rates
        values = {"rate": needed.rates[1], "slowest": slowest, "fastest": fastest}
        found.append(Remark("coverage rates", values | {"asked": needed.rates[1] / NEAR}))
    if needed.cycles > 1 and measured.cycles < min(needed.cycles, ENOUGH_CYCLES):
        values = {"needed": needed.cycles, "cycles": measured.cycles, "enough": ENOUGH_CYCLES}
        found.append(Remark("coverage cycles", values))
    return found


def nesting_of(points: Sequence[float], tolerance: float = 0.0) -> int:
    """Returns the most reversals that a motion remembers at once, see `Coverage`.

    The points are first angle, reversals and last angle [rad]; an angle within the tolerance [rad]
    counts as reached.
    """
    remembered: list[float] = []
    deepest = 0
    low, high = sorted(points[:2])
    for before, angle in pairwise(points[1:]):
        remembered.append(before)
        deepest = max(deepest, len(remembered))
        up = 1.0 if angle > before else -1.0
        while len(remembered) > 1 and up * (angle - remembered[-2]) >= -tolerance:
            del remembered[-2:]
        if angle >= high - tolerance or angle <= low + tolerance:
            remembered.clear()
        low, high = min(low, angle), max(high, angle)
    return deepest


class _Branches(NamedTuple):
    """One motion: length of its branches [rad], their rates [rad/s], its nesting and cycles."""

    ways: Array
    rates: list[float]
    nesting: int
    cycles: int


def _branches(time: Array | None, angle: Array) -> _Branches:
    span = float(np.ptp(angle))
    dead_band = max(estimate_dead_band(angle), SMALLEST * span)
    ends = _ends(angle, reversals(angle, dead_band).tolist())
    ways, rates = np.abs(np.diff(angle[ends])), []
    if time is not None:
        for start, stop in pairwise(ends):
            here = slice(start, stop + 1)
            rates.append(_rate(angle[here], time[here], dead_band))
    whole = int(np.count_nonzero(ways >= WHOLE * span))
    return _Branches(ways, rates, nesting_of(angle[ends].tolist(), SMALLEST * span), whole // 2)


def _ends(angle: Array, turns: list[int]) -> list[int]:
    """Returns the samples where branches end: turns, with an extreme before and an extreme after.

    The first and the last sample of a motion may be too near to a turn to count as branches.
    """
    if not turns:
        return sorted([int(angle.argmin()), int(angle.argmax())])
    first, last = angle[: turns[0] + 1], angle[turns[-1] :]
    begin = first.argmin() if 2 * first[-1] > first.min() + first.max() else first.argmax()
    end = last.argmin() if 2 * last[0] > last.min() + last.max() else last.argmax()
    return [int(begin), *turns, turns[-1] + int(end)]


def _rate(angle: Array, time: Array, dead_band: float) -> float:
    """Returns the rate of the fastest part of a branch [rad/s]; each part is longer than noise."""
    way = np.abs(angle - angle[0])
    parts = int(np.clip(way[-1] / dead_band, 1, PARTS))
    levels = np.linspace(0, way[-1], parts + 1)
    took = np.diff(np.interp(levels, np.maximum.accumulate(way), time))
    return float(levels[1] / took.min())
