"""Fits of a hysteresis model behind play in the transmission."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ...hysteresis.around import Backlash, without_rate
from ...hysteresis.protocol import HysteresisModel
from ..curves import Curve
from ..lost_motion import suit_angles
from ..objective import InitialTorque
from ..prediction import nrmse, price, torque_errors
from .rate import SlowFit

Play = Literal["none", "fit"]
LARGEST = 0.1  # widest gap of the search, as a share of the range of angles
GAPS = 6  # number of gaps on the grid, of which the first is zero
CLOSE = 1e-3  # tolerance of the best gap, relative to the widest


class _Behind(NamedTuple):
    model: HysteresisModel
    initial_torque: InitialTorque
    loss: float


def play_of(model: HysteresisModel) -> Play:
    """Returns whether a fitted model is behind play."""
    return "fit" if isinstance(without_rate(model), Backlash) else "none"


def without_play(model: HysteresisModel) -> HysteresisModel:
    """Returns the model behind the play, or the model itself where there is none."""
    return model.model if isinstance(model, Backlash) else model


def fit_behind_play(
    curves: Sequence[Curve],
    fit: Callable[[Sequence[Curve]], SlowFit],
    quick: Callable[[Sequence[Curve]], SlowFit],
) -> tuple[HysteresisModel, InitialTorque]:
    """Fits a hysteresis model and the gap before it.

    For a given gap, the sign of the torque shows the face in contact, and so the angle of the
    suit's side, to which the model is fitted; where the torque is lost in the noise, the suit's
    side moves only as far as the joint pushes it. The gap, up to 10 % of the range, is the one for
    which the model behind it is nearest to the torque: the best of a grid, refined by Brent's
    bounded search. A gap that lowers the error by less than the cost of its parameter (the
    Bayesian information criterion) does not count, and the model is returned without it.

    Args:
        curves: Measured curves.
        fit: Fit of the hysteresis model to curves.
        quick: The same with less effort, which suffices to compare gaps.
    """
    found: dict[float, _Behind] = {}

    def loss(gap: float) -> float:
        if gap not in found:
            found[gap] = _behind(curves, gap, quick)
        return found[gap].loss

    widest = LARGEST * max(float(np.ptp(curve.angle)) for curve in curves)
    grid = np.linspace(0.0, widest, GAPS)
    best = int(np.argmin([loss(float(gap)) for gap in grid]))
    near = grid[max(best - 1, 0)], grid[min(best + 1, GAPS - 1)]
    minimize_scalar(
        lambda gap: loss(float(gap)),
        bounds=near,
        method="bounded",
        options={"xatol": CLOSE * widest},
    )
    gap = min(found, key=loss)
    chosen, without = _behind(curves, gap, fit), _behind(curves, 0.0, fit)
    if without.loss <= chosen.loss * price(1, _samples(curves)):
        chosen = without
    return chosen.model, chosen.initial_torque


def _behind(
    curves: Sequence[Curve], gap: float, fit: Callable[[Sequence[Curve]], SlowFit]
) -> _Behind:
    """Returns the fit of a model behind a known gap, with its error along the curves."""
    if gap == 0:
        slow = fit(curves)
        error = _error(slow.model, slow.initial_torque, curves)
        return _Behind(slow.model, slow.initial_torque, error)
    slow = fit([replace(one, angle=suit_angles(one, gap)) for one in curves])
    behind = Backlash(model=slow.model, gap=gap)
    starts: list[InitialTorque] = [slow.initial_torque]
    # A start within the noise counts as one in the gap where that is nearer to the curves.
    if not isinstance(slow.initial_torque, str) and slow.initial_torque != 0:
        starts.append(0.0)
    tried = [_Behind(behind, one, _error(behind, one, curves)) for one in starts]
    return min(tried, key=lambda one: one.loss)


def _samples(curves: Sequence[Curve]) -> int:
    return sum(curve.angle.size for curve in curves)


def _error(model: HysteresisModel, start: InitialTorque, curves: Sequence[Curve]) -> float:
    return nrmse(torque_errors(model, start, curves), curves)
