"""Functions of joint angles that are sums of products of their sines and cosines."""

# pyright: reportCallIssue=false

import copy
import math
from collections.abc import Callable

import numpy as np
from numba import njit

from ...arrays import Array


class Trigonometric:
    """A function of joint angles that is a polynomial of a degree in their sines and cosines.

    Levers between joints that turn about fixed axes are of degree 1, masses of degree 2. The
    coefficients follow from as many evenly spaced poses as there are products, without error.

    Args:
        function: Function from a pose [rad], shape (joints,), to numbers, any shape.
        joints: Number of joints.
        degree: Highest degree of the sine and cosine of one joint.

    Attributes:
        coefficients: Coefficients of the products, shape (products, numbers). The products of the
            first joints come first, and joint j multiplies them by 1, sin(k angle), cos(k angle).
    """

    def __init__(self, function: Callable[[Array], Array], joints: int, degree: int) -> None:
        turns = np.arange(2 * degree + 1) * math.tau / (2 * degree + 1)
        poses = np.array(np.meshgrid(*[turns] * joints)).reshape(joints, -1).T
        values = np.array([function(pose) for pose in poses])
        products = np.empty((len(poses), len(poses)))
        for pose, row in zip(poses, products, strict=True):
            _multiply(pose, degree, -1, row)
        self.coefficients = np.linalg.solve(products, values.reshape(len(poses), -1))
        self._degree, self._shape = degree, values.shape[1:]

    def __sub__(self, other: "Trigonometric") -> "Trigonometric":
        """Returns the difference of two functions of the same joints and degree."""
        rest = copy.copy(self)
        rest.coefficients = self.coefficients - other.coefficients
        return rest

    def __call__(self, angle: Array, slope: int = -1) -> Array:
        """Returns the values, shape (n, ...), or their derivative.

        Args:
            angle: Angles [rad], shape (n, joints).
            slope: Joint with respect to whose angle to differentiate; -1 is none.
        """
        found = np.zeros((len(angle), self.coefficients.shape[1]))
        _sum(np.ascontiguousarray(angle), self._degree, slope, self.coefficients, found)
        return found.reshape(len(angle), *self._shape)


@njit(cache=True)
def _sum(angle, degree, slope, coefficients, found) -> None:
    products = np.empty(coefficients.shape[0])
    for row in range(angle.shape[0]):
        _multiply(angle[row], degree, slope, products)
        for i in range(products.size):
            for j in range(found.shape[1]):
                found[row, j] += products[i] * coefficients[i, j]


@njit(cache=True)
def _multiply(angle, degree, slope, products) -> None:
    """Fills in the products of 1, sines and cosines of multiples of each joint's angle."""
    products[0], count = 1.0, 1
    for j in range(angle.size):
        for k in range(1, degree + 1):
            s, c = math.sin(k * angle[j]), math.cos(k * angle[j])
            if j == slope:
                s, c = k * c, -k * s
            for i in range(count):
                products[(2 * k - 1) * count + i] = s * products[i]
                products[2 * k * count + i] = c * products[i]
        if j == slope:
            products[:count] = 0.0
        count *= 2 * degree + 1
