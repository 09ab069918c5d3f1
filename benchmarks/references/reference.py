"""Slow, readable reference models, written from the equations and not from the kernels.

A reference follows a motion from sample to sample with `move`; with its `slope` and `knots` SciPy
can integrate the same motion by itself (`integrate`). Tests and the benchmark `exactness`
compare the kernels and the engine with both.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...hysteresis import HysteresisModel


@dataclass(frozen=True, kw_only=True)
class Example:
    """A model, and a motion with which tests and benchmarks examine it.

    Attributes:
        name: Name that a table shows.
        model: The model.
        low: Lowest angle of the motion, at which it starts [rad].
        high: Highest angle of the motion [rad].
        start_torque: Resistance at the start [N·m].
    """

    name: str
    model: HysteresisModel
    low: float
    high: float
    start_torque: float = 0.0


class Reference(ABC):
    """A readable model that follows a motion from sample to sample.

    Attributes:
        angle: Present angle [rad].
        torque: Resistance at that angle [N·m].
    """

    def __init__(self, angle: float, torque: float) -> None:
        self.angle, self.torque = float(angle), float(torque)

    def move(self, angle: float) -> float:
        """Makes a monotone motion to `angle` [rad] and returns the torque [N·m] there."""
        if angle != self.angle:
            self.torque, self.angle = self._torque_after(angle), float(angle)
        return self.torque

    @abstractmethod
    def _torque_after(self, angle: float) -> float:
        """Moves the memory by a monotone motion to `angle` and returns the torque [N·m] there."""

    @abstractmethod
    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] at a later point of the present branch.

        The branch begins at the present angle of the reference and moves with the sign `delta`.
        """

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] on the way to `end` where the slope is not smooth.

        The list may have other angles too.
        """
        return []


def runge_kutta(
    slope: Callable[[float, float, float], float], x: float, y: float, h: float
) -> float:
    """Returns y after one classical step of dy/dx = slope(x, y, sign of h)."""
    delta = math.copysign(1.0, h)
    k1 = slope(x, y, delta)
    k2 = slope(x + h / 2, y + h / 2 * k1, delta)
    k3 = slope(x + h / 2, y + h / 2 * k2, delta)
    k4 = slope(x + h, y + h * k3, delta)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def turn_indices(angles: Array) -> NDArray[np.intp]:
    """Returns the indices of the samples at which a motion turns, and of its last sample."""
    moved = np.flatnonzero(np.diff(angles, prepend=math.inf))
    turned = np.diff(np.sign(np.diff(angles[moved])))
    return np.append(moved[1:-1][turned != 0], angles.size - 1)


Make = Callable[[Any, Array, float], Reference]
M = TypeVar("M", bound=Make)

_MAKERS: dict[type[HysteresisModel], Make] = {}


def refers_to(kind: type[HysteresisModel]) -> Callable[[M], M]:
    """Registers a reference, which is made from a model, all angles and the first torque.

    Args:
        kind: Class of the models.
    """

    def register(make: M) -> M:
        _MAKERS[kind] = make
        return make

    return register


def reference_of(model: HysteresisModel, angles: Array, torque: float) -> Reference:
    """Returns a slow, readable model, written from the equations and not from the kernels.

    Args:
        model: The model.
        angles: Angles of the whole motion that it will follow [rad], shape (n,).
        torque: Resistance at the first of them [N·m].

    Raises:
        NotImplementedError: The model has no reference.
    """
    if type(model) not in _MAKERS:
        raise NotImplementedError(f"model {model.name!r} has no reference model")
    return _MAKERS[type(model)](model, angles, torque)


def integrate(reference: Reference, angle: Array, tolerance: float = 1e-10) -> Array:
    """Integrates dT/dtheta by DOP853, from turn to turn and from knot to knot.

    Args:
        reference: Reference model at the first angle; the integration moves it.
        angle: Angles of a motion [rad], shape (n,).
        tolerance: Relative and absolute tolerance of DOP853.

    Returns:
        Torque [N·m], shape (n,).
    """
    torque = np.empty_like(angle)
    now, first = reference.torque, 0
    for last in turn_indices(angle):
        branch = angle[first : last + 1]
        start, end = float(branch[0]), float(branch[-1])
        inside = [x for x in reference.knots(end) if min(start, end) < x < max(start, end)]
        for a, b in pairwise(sorted({start, *inside, end}, reverse=end < start)):
            solved = _solve(reference, a, b, now, tolerance)
            here = np.flatnonzero((branch >= min(a, b)) & (branch <= max(a, b)))
            if here.size > 0:
                torque[first + here] = solved.sol(branch[here])[0]
            now = float(solved.y[0, -1])
        reference.move(end)
        first = last
    return torque


def _solve(reference: Reference, a: float, b: float, torque: float, tolerance: float) -> Any:
    """Integrates dT/dtheta between two angles [rad].

    The slope may jump at both of them, so it is evaluated just inside.
    """
    delta = math.copysign(1.0, b - a)
    inset = delta * min(1e-13, abs(b - a) / 4)
    low, high = sorted((a + inset, b - inset))
    from scipy.integrate import solve_ivp  # SciPy takes long to import

    return solve_ivp(
        lambda x, T: [reference.slope(min(max(x, low), high), T[0], delta)],
        (a, b),
        [torque],
        "DOP853",
        dense_output=True,
        rtol=tolerance,
        atol=tolerance,
    )
