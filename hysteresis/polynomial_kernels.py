"""Kernels of an elastic torque that is a polynomial of the angle, coefficients constant first."""

from numba import njit


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
