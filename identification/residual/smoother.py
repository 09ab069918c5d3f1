"""An upper bound on the noise: what a smooth curve through each branch leaves.

No model is smoother than the joint that it describes, so what a flexible smooth curve through each
branch alone leaves is noise. A fit that leaves more may describe a joint whose noise wanders, or
may be wrong: only repeated curves can tell.
"""

import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import BSpline

from ...arrays import Array
from ...hysteresis.loops import branches
from ..curves import Curve

PIECES = 12  # largest number of polynomial pieces of a branch
SAMPLES = 6  # least number of samples of a piece
CUBIC = 3  # degree of the pieces


def smoother_noise(curves: Sequence[Curve]) -> float:
    """Returns the standard deviation of what smooth curves through all branches leave [N·m].

    Each branch has its own cubic spline over the samples, whose pieces are shorter after the
    reversal, where a hysteretic torque bends most. The deviation accounts for their number.

    Args:
        curves: The measured curves.
    """
    left, freedom = 0.0, 0
    for curve in curves:
        pieces = branches(curve.angle, curve.torque) if curve.angle.size > 2 else ()
        for piece in pieces:
            torque = curve.torque[piece.start : piece.stop]
            columns = _spline(torque.size)
            if torque.size <= columns.shape[1]:
                continue
            rest = torque - columns @ np.linalg.lstsq(columns, torque, rcond=None)[0]
            left += float(rest @ rest)
            freedom += torque.size - columns.shape[1]
    return math.sqrt(left / freedom) if freedom else math.inf


def _spline(samples: int) -> Array:
    """Returns cubic B-splines over a branch, shape (samples, columns)."""
    count = min(max(samples // SAMPLES, 1), PIECES)
    inner = (samples - 1) * np.linspace(0, 1, count + 1) ** 2
    inner = np.maximum(inner, np.arange(count + 1))  # at least one sample in each piece
    ends = np.full(CUBIC, inner[0]), np.full(CUBIC, inner[-1])
    knots = np.concatenate([ends[0], inner, ends[1]])
    return BSpline.design_matrix(np.arange(samples, dtype=float), knots, CUBIC).toarray()
