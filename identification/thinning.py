"""Thinning of long records: the samples that a fit uses, and the points that a figure draws."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..hysteresis.loops import estimate_dead_band, reversals
from .curves import Curve, Curves

FITTED = 50_000  # approximate number of samples of all curves of a fit together
DRAWN = 4_000  # approximate number of points of all curves of a panel together


def thinned(curves: Sequence[Curve], most: int = FITTED) -> Curves:
    """Returns curves of about `most` samples in all: those given, unless they have more.

    Of each curve every n-th sample stays, with its two ends and its turning points; n is the number
    of samples over `most`, rounded up. Samples are left as they are, noise included.
    """
    every = _step(curves, most)
    if every == 1:
        return Curves(curves)
    family = Curves(curves)
    short = (_picked(curve, kept_samples(curve.angle, every)) for curve in family)
    return family.of(short)


def thinning_note(curves: Sequence[Curve], most: int = FITTED) -> str:
    """Returns what `thinned` does to these curves, as a sentence; empty if it does nothing."""
    every = _step(curves, most)
    if every == 1:
        return ""
    used = _samples(thinned(curves, most))
    return (
        f"{used:,} of {_samples(curves):,} samples are used: one in {every} of each curve, its "
        "ends and its turning points"
    )


def drawn_samples(curves: Sequence[Curve], most: int = DRAWN) -> list[NDArray[np.intp]]:
    """Returns the indices of the samples to draw of each curve of a panel, about `most` in all."""
    every = _step(curves, most)
    return [kept_samples(curve.angle, every) for curve in curves]


def drawn_note(curves: Sequence[Curve], most: int = DRAWN) -> str:
    """Returns how many samples of a panel's curves are drawn, in words; empty if all are."""
    drawn = sum(indices.size for indices in drawn_samples(curves, most))
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


def _picked(curve: Curve, indices: NDArray[np.intp]) -> Curve:
    time = None if curve.time is None else curve.time[indices]
    return replace(curve, angle=curve.angle[indices], torque=curve.torque[indices], time=time)


def _step(curves: Sequence[Curve], most: int) -> int:
    return max(1, -(-_samples(curves) // most))


def _samples(curves: Sequence[Curve]) -> int:
    return sum(curve.angle.size for curve in curves)
