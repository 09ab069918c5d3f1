"""Elastic torques that are polynomials of the angle: checks, extremes and kernels."""

import numpy as np
from numba import njit
from numpy.polynomial import polynomial as poly

from ..checks import numbers
from ..errors import InputError
from .protocol import POLYNOMIAL, Numbers

LARGEST_DEGREE = 5
NEGLIGIBLE = 1e-15  # share of the largest term below which a leading one changes no extreme


def coefficients(name: str, values: Numbers) -> tuple[float, ...]:
    """Returns the coefficients of a polynomial, constant first [N·m/rad^i]."""
    found = numbers(name, values, POLYNOMIAL)
    if len(found) > LARGEST_DEGREE + 1:
        raise InputError(
            f"{name} has {len(found)} coefficients: give at most {LARGEST_DEGREE + 1}, of theta^0 "
            f"to theta^{LARGEST_DEGREE}"
        )
    return found


def extremes(polynomial: Numbers, low: float, high: float) -> tuple[float, float]:
    """Returns the least and the largest torque [N·m] in a range of angles [rad], maybe infinite."""
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


@njit
def value_of(polynomial, angle):
    """Returns the elastic torque of the polynomial."""
    value = 0.0
    for power in range(polynomial.size - 1, -1, -1):
        value = value * angle + polynomial[power]
    return value


@njit
def slope_of(polynomial, angle):
    """Returns the derivative of the polynomial with respect to the angle."""
    slope = 0.0
    for power in range(polynomial.size - 1, 0, -1):
        slope = slope * angle + power * polynomial[power]
    return slope


@njit
def work_of(polynomial, angle):
    """Returns the integral of the polynomial from angle 0."""
    work = 0.0
    for power in range(polynomial.size - 1, -1, -1):
        work = work * angle + polynomial[power] / (power + 1)
    return work * angle
