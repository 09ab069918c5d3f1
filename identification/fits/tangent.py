"""Derivatives of the torque of a model with respect to its fitted parameters."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve
from .objective import InitialTorque, predicted
from .parameters import EVERY, FREE, Constraints, Parameter, Path, parameters_of, with_values

STEP = 1e-5  # step of a coordinate, relative to its size
SMALLEST = 1e-3  # size of a coordinate below which steps do not shrink further
RANK = 1e-9  # relative singular value below which columns depend on each other


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The free parameters of a fitted model as coordinates of the fit.

    The coordinate of a parameter that has a least value, such as c > 1 of a certified
    Jiles-Atherton model, is the logarithm of its distance from the least value. Parameters that are
    fixed, at their least value or at a bound of the user have no coordinate.

    Attributes:
        names: Name of each coordinate, shape (p,).
        values: The parameters themselves, in the model's units, shape (p,).
        least: Least value of each; -inf where there is none.
    """

    names: tuple[str, ...]
    values: Array
    least: Array
    _paths: tuple[Path, ...]
    _content: dict[str, Any]
    _start: InitialTorque

    @property
    def point(self) -> Array:
        """The coordinates, shape (p,)."""
        limited = np.isfinite(self.least)
        away = np.where(limited, self.values - self.least, 1.0)
        return np.where(limited, np.log(away), self.values)

    def numbers(self, point: Array) -> Array:
        """Returns the parameters of a point, shape (p,)."""
        limited = np.isfinite(self.least)
        with np.errstate(over="ignore"):  # an interval without an end
            return np.where(limited, np.where(limited, self.least, 0) + np.exp(point), point)

    def slopes(self) -> Array:
        """Returns the derivative of each parameter with respect to its coordinate, shape (p,)."""
        return np.where(np.isfinite(self.least), self.values - self.least, 1.0)

    def at(self, point: Array) -> tuple[HysteresisModel, InitialTorque]:
        """Returns model and initial torque of a point."""
        values = dict(zip(self._paths, self.numbers(point).tolist(), strict=True))
        start = values.pop((), self._start)
        return with_values(self._content, values), start


def coordinates_of(
    model: HysteresisModel,
    initial_torque: InitialTorque,
    *,
    fitted_start: bool,
    constraints: Constraints = FREE,
) -> Coordinates:
    """Returns the free parameters of a fitted model, and a fitted first torque, as coordinates."""
    every = parameters_of(model, constraints)
    found = [one for one in every if one.value > one.least and one.state == "free"]
    if fitted_start and not isinstance(initial_torque, str):
        start = float(initial_torque)
        found.append(Parameter("initial_torque", "N·m", start, *EVERY[:1], *EVERY, ()))
    return Coordinates(
        names=tuple(one.name for one in found),
        values=np.array([one.value for one in found]),
        least=np.array([one.least for one in found]),
        _paths=tuple(one.path for one in found),
        _content=model.to_dict(),
        _start=initial_torque,
    )


def tangent(coordinates: Coordinates, curves: Sequence[Curve]) -> Array:
    """Returns the derivatives of the torque with respect to the coordinates, shape (samples, p).

    They are central differences; one-sided ones if on the other side no such model exists or the
    model meets its pole; and zero if that is so on both sides.
    """
    point = coordinates.point

    def torque(at: Array) -> Array:
        model, start = coordinates.at(at)
        return np.concatenate([predicted(model, start, curve) for curve in curves])

    here, columns = torque(point), []
    for i, value in enumerate(point):
        step = STEP * max(abs(value), SMALLEST) if coordinates.least[i] == -np.inf else STEP
        sides = []
        for sign in (1.0, -1.0):
            moved = point.copy()
            moved[i] += sign * step
            try:
                there = torque(moved)
            except InputError:
                continue
            if np.isfinite(there).all():
                sides.append((there - here) / (sign * step))
        if sides:
            columns.append(np.mean(sides, axis=0))
        else:
            columns.append(np.zeros_like(here))
    return np.column_stack(columns) if columns else np.empty((here.size, 0))


def independent(columns: Array) -> Array:
    """Returns an orthonormal basis of the span of columns, shape (samples, rank)."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, size > 0] / size[size > 0]
    if not scaled.size:
        return np.empty((len(columns), 0))
    basis, singular, _ = np.linalg.svd(scaled, full_matrices=False)
    return basis[:, singular > RANK * singular[0]]


def beside(basis: Array, columns: Array) -> Array:
    """Returns columns less their projection on an orthonormal basis (samples, rank)."""
    return columns - basis @ (basis.T @ columns)
