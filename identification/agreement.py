"""Whether the kinds of model that describe the curves agree on the intended motions.

First-order curves alone never show it. Where a rate or unlike branches act, models of all kinds
agree with such curves and with each other, and are wrong together. So only a band that predictions
of left-out curves have tested extends a verdict beyond the curves.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import InputError
from .curves import Curve
from .ensemble import LEVEL, Ensemble
from .motion_files import Motion
from .prediction import predicted

NARROW = 0.05  # half width over the peak; a larger error needs repeats in a verdict, too


class Agreement(NamedTuple):
    """How far kinds of model differ on motions.

    Attributes:
        half_width: Largest mean half width of a motion's band [N·m]; without a band half the
            difference of the models, and infinite where they cannot be compared.
        tested: Whether that is the width of a band that left-out curves have tested.
        sentence: Both in words.
    """

    half_width: float
    tested: bool
    sentence: str


def agreement(found: Ensemble, motions: Sequence[Motion], peak: float) -> Agreement | None:
    """Returns how far the members of an ensemble differ; None without a motion that moves.

    Args:
        found: Ensemble.
        motions: Intended motions.
        peak: Largest torque of the curves [N·m].
    """
    moving = [one for one in motions if np.ptp(one.angle) > 0]
    if not moving:
        return None
    try:
        curves = [
            Curve(one.angle, np.zeros(len(one.angle)), f"motion {i}", time=one.time)
            for i, one in enumerate(moving)
        ]
        bands, tested = _bands(found, curves)
    except InputError as error:
        return _unknown(str(error))
    half = max(float(np.mean(high - low)) / 2 for low, high in bands)
    if not math.isfinite(half):
        return _unknown("one of them meets its pole there")
    within = f"{half:.2g} N·m ({half / peak:.1%} of the peak)"
    if tested:
        by = f"curve {found.nested[0]!r}" if found.nested else "left-out curves"
        sentence = (
            f"on the intended motion the torque is within {within} at {LEVEL:.0%}, over all kinds "
            f"of model and tested by predictions of {by}"
        )
    else:
        sentence = (
            f"on the intended motion the {len(found.members)} kinds of model that predict the "
            f"curves are within {within} of each other's middle, but no curve has loops inside "
            "loops to test them: all may be wrong together"
        )
    return Agreement(half, tested, sentence)


def _bands(found: Ensemble, curves: Sequence[Curve]) -> tuple[list[tuple[Array, Array]], bool]:
    """Returns the bands along curves, and whether left-out curves have tested such bands."""
    try:
        return [found.band(curve) for curve in curves], True
    except InputError:
        if found.tested:
            raise
        return [_between(found, curve) for curve in curves], False


def _between(found: Ensemble, curve: Curve) -> tuple[Array, Array]:
    torque = [predicted(one.model, one.initial_torque, curve) for one in found.members]
    return np.min(torque, axis=0), np.max(torque, axis=0)


def _unknown(why: str) -> Agreement:
    sentence = f"the kinds of model cannot be compared on the intended motion: {why}"
    return Agreement(math.inf, False, sentence)
