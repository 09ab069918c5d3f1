"""The work that measured loops take: a joint whose loops give work back drives its wearer."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.loops import Branch, branches
from .curves import Curve, Curves, noise_floor

ROUNDING = 1e-9  # angle [rad]: its product with the peak counts as no work
SURELY = -3.0  # standard deviations that noise alone reaches in one of 700 cases


class LoopWork(NamedTuple):
    """Work of the closed parts of some curves.

    Attributes:
        work: Sum over all pairs of branches of the work in the range that both share [J].
        deviation: Standard deviation of the work due to the noise of the torque [J].
        rise: Sum over all branches of change of torque times change of angle [J].
        rise_deviation: Standard deviation of the rise due to that noise [J].
    """

    work: float
    deviation: float
    rise: float
    rise_deviation: float

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
        rise += sum(float(np.ptp(one.angle[[0, -1]]) * _gain(one)) for one in pieces)
        ways += sum(2 * float(np.ptp(one.angle[[0, -1]])) ** 2 for one in pieces)
        for one, other in pairwise(pieces):
            low = max(one.angle.min(), other.angle.min())
            high = min(one.angle.max(), other.angle.max())
            if high <= low:
                continue
            for piece in (one, other):
                angle, torque = _rising(piece)
                grid = np.unique(np.clip(angle, low, high))
                there = np.interp(grid, angle, torque)
                work += piece.direction * float(np.trapezoid(there, grid))
                variance += float(np.sum(np.gradient(grid) ** 2)) if grid.size > 1 else 0.0
    rounding = ROUNDING * Curves(curves).peak
    deviation, rise_deviation = (
        math.hypot(noise * math.sqrt(one), rounding) for one in (variance, ways)
    )
    return LoopWork(work, deviation, rise, rise_deviation)


def refuse_driven(curves: Sequence[Curve]) -> None:
    """Refuses curves whose torque surely has the wrong sign.

    Their loops give energy to the joint, and the torque falls where the angle rises. The first
    alone is no mistake: a joint that begins far from rest gives back what it had stored.
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


def _gain(piece: Branch) -> float:
    return piece.direction * float(piece.torque[-1] - piece.torque[0])


def _rising(piece: Branch) -> tuple[Array, Array]:
    order = np.argsort(piece.angle, kind="stable")
    return piece.angle[order], piece.torque[order]
