"""The mean of the cycles of a repeated motion."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.loops import reversals
from ..data.curves import Curve, Curves

TOLERANCE = 0.02  # largest distance of turns that are alike, over the angle's range
FEWEST = 2  # fewest cycles after the first of which a mean is taken


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
