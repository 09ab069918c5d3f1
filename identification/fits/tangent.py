"""Derivatives of the torque of a model with respect to its fitted parameters."""

import copy
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.protocol import HysteresisModel
from ...hysteresis.registry import model_from_dict
from ..data.curves import Curve
from .objective import InitialTorque, predicted

STEP = 1e-5  # step of a coordinate, relative to its size
SMALLEST = 1e-3  # size of a coordinate below which steps do not shrink further
Path = tuple[str | int, ...]
RANK = 1e-9  # relative singular value below which columns depend on each other


@dataclass(frozen=True, eq=False)
class Coordinates:
    """The parameters of a fitted model as coordinates of the fit.

    A parameter that has a least value, such as c > 1 of a certified Jiles-Atherton model, is given
    by the logarithm of its distance from that value. A parameter at its least value is no
    coordinate: there the fit stops.

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
        return self._inner(self.values)

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
        content, start = copy.deepcopy(self._content), self._start
        for path, value in zip(self._paths, self.numbers(point).tolist(), strict=True):
            if path == ():
                start = value
                continue
            place: Any = content
            for key in path[:-1]:
                place = place[key]
            place[path[-1]] = value
        return model_from_dict(content), start

    def _inner(self, values: Array) -> Array:
        limited = np.isfinite(self.least)
        away = np.where(limited, values - self.least, 1.0)
        return np.where(limited, np.log(away), values)


def coordinates_of(
    model: HysteresisModel, initial_torque: InitialTorque, *, fitted_start: bool
) -> Coordinates:
    """Returns the fitted parameters of a model as coordinates.

    Args:
        model: Fitted model.
        initial_torque: Torque with which the curves begin [N·m], or "measured".
        fitted_start: Whether the fit chose that torque.
    """
    content = model.to_dict()
    found = [one for one in _numbers((), content) if one[2] > one[3]]
    if fitted_start and not isinstance(initial_torque, str):
        found.append(((), "initial_torque", float(initial_torque), -math.inf))
    return Coordinates(
        names=tuple(one[1] for one in found),
        values=np.array([one[2] for one in found]),
        least=np.array([one[3] for one in found]),
        _paths=tuple(one[0] for one in found),
        _content=content,
        _start=initial_torque,
    )


def tangent(coordinates: Coordinates, curves: Sequence[Curve]) -> Array:
    """Returns derivatives of the torque with respect to the coordinates, shape (samples, p).

    They are differences along the curves, one-sided where the model does not exist, or meets its
    pole, on one side.
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


def _numbers(path: Path, content: Any, name: str = "") -> Iterator[tuple[Path, str, float, float]]:
    """Yields path, name, value and least value of every fitted parameter."""
    if isinstance(content, dict):
        model = model_from_dict(content)
        for key, value in content.items():
            if key in model.not_fitted:
                continue
            if isinstance(value, dict):
                yield from _numbers((*path, key), value)
                continue
            for place, inner, number in _flat((*path, key), key, value):
                yield place, inner, number, model.least.get(key, -math.inf)


def _flat(path: Path, name: str, value: Any) -> Iterator[tuple[Path, str, float]]:
    if isinstance(value, list | tuple):
        for i, one in enumerate(value):
            yield from _flat((*path, i), f"{name}[{i}]", one)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield path, name, float(value)


def independent(columns: Array) -> Array:
    """Returns an orthonormal basis of what columns span, shape (samples, rank)."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns[:, size > 0] / size[size > 0]
    if not scaled.size:
        return np.empty((len(columns), 0))
    basis, singular, _ = np.linalg.svd(scaled, full_matrices=False)
    return basis[:, singular > RANK * singular[0]]


def beside(basis: Array, columns: Array) -> Array:
    """Returns what an orthonormal basis (samples, rank) does not explain of columns."""
    return columns - basis @ (basis.T @ columns)
