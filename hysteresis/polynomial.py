"""Elastic torques that are polynomials of the angle: checks, scales and extremes."""

import numpy as np
from numpy.polynomial import polynomial as poly

from ..checks import numbers
from ..errors import InputError
from .protocol import POLYNOMIAL, Numbers

LARGEST_DEGREE = 5
UNIT = POLYNOMIAL
NEGLIGIBLE = 1e-15  # share of the largest term below which a leading one changes no extreme


def coefficients(name: str, values: Numbers) -> tuple[float, ...]:
    """Returns the coefficients of a polynomial, constant first [N·m/rad^i]."""
    found = numbers(name, values, UNIT)
    if len(found) > LARGEST_DEGREE + 1:
        raise InputError(
            f"{name} has {len(found)} coefficients: give at most {LARGEST_DEGREE + 1}, of theta^0 "
            f"to theta^{LARGEST_DEGREE}"
        )
    return found


def rescaled(polynomial: Numbers, torque: float, angle: float) -> list[float]:
    """Returns the polynomial whose value at angle * theta is `torque` times this one's at theta."""
    return [float(p) * torque / angle**i for i, p in enumerate(polynomial)]


def extremes(polynomial: Numbers, low: float, high: float) -> tuple[float, float]:
    """Returns the least and the largest torque [N·m] in a range of angles [rad].

    They are infinite if the range is and the torque is not constant.
    """
    if not any(polynomial[1:]):
        return float(polynomial[0]), float(polynomial[0])
    if not np.isfinite(high - low):
        return -np.inf, np.inf
    powers = np.arange(len(polynomial))
    sizes = np.abs(polynomial) * max(abs(low), abs(high)) ** powers
    degree = powers[1:][sizes[1:] >= NEGLIGIBLE * sizes[1:].max()].max()
    turns = poly.polyroots(poly.polyder(polynomial[: degree + 1]))
    inside = [x.real for x in turns if abs(x.imag) < 1e-9 and low < x.real < high]
    torque = poly.polyval(np.array([low, high, *inside]), np.array(polynomial))
    return float(torque.min()), float(torque.max())
