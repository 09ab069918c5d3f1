"""The offset of a torque sensor: its estimate and its removal."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

from scipy.optimize import minimize_scalar

from ...errors import InputError
from ..data.curves import Curves

Tare = float | Literal["zero", "fit"]
FINE = 1e-3  # tolerance of a fitted offset, as a share of the peak
FLAT = 1.02  # ratio to the least error, below which another offset fits as well: none is identified


def tared(curves: Curves, tare: float) -> Curves:
    """Returns curves less an offset of the torque sensor [N·m]."""
    if tare == 0:
        return curves
    rest = (replace(curve, torque=curve.torque - tare) for curve in curves)
    return curves.of(rest)


def found_tare(family: Curves, tare: Tare, error: Callable[[Curves], float]) -> float:
    """Returns the offset of the torque sensor [N·m].

    "zero" is the mean torque at the beginning of the curves, "fit" the offset with the least error
    of a fit; `error` returns the error of the fit of curves over their peak.
    """
    if tare == "zero":
        return family.start_torque
    if tare != "fit":
        return float(tare)
    peak = family.peak
    found: Any = minimize_scalar(
        lambda offset: _misses(tared(family, offset), error),
        bounds=(-peak / 2, peak / 2),
        method="bounded",
        options={"xatol": FINE * peak},
    )
    best = float(found.x)
    if is_open(tared(family, best), error):
        raise InputError(
            "tare is 'fit', but the model fits these curves with any offset: leave it out, or "
            "give the offset as a number"
        )
    return best


def is_open(curves: Curves, error: Callable[[Curves], float]) -> bool:
    """Returns whether a model fits curves as well with another offset of a quarter of the peak."""
    return _misses(tared(curves, curves.peak / 4), error) < FLAT * _misses(curves, error)


def _misses(curves: Curves, error: Callable[[Curves], float]) -> float:
    """Returns the root mean square error of a fit [N·m], or a large number if no fit exists."""
    try:
        return error(curves) * curves.peak
    except InputError:  # nothing certified fits such curves
        return 10 * curves.peak
