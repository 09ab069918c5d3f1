"""Slow, readable twins of all models, written from their equations and not from their kernels.

A twin follows a motion from sample to sample with `move`. With `slope` and `knots` SciPy can
integrate the same motion by itself.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ...hysteresis import Asymmetric, BoucWen, Held, JilesAtherton, PrandtlIshlinskii, Preisach
from ...hysteresis.protocol import HysteresisModel

FIELD_STEP = 0.05  # of the Runge-Kutta steps of Jiles-Atherton, in degrees
ANGLE_STEP = 1e-3  # of those of Bouc-Wen [rad]


class Twin(ABC):
    """A model on its way along a motion.

    Attributes:
        angle: where it is [rad].
        torque: the resistance there [N·m].
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
        """Returns dT/dtheta [N·m/rad] at a later point of the branch, which has the sign `delta`.

        The branch begins where the twin is.
        """

    def knots(self, end: float) -> list[float]:
        """Returns angles [rad] with all on the way to `end` where the slope is not smooth."""
        return []


class JilesAthertonTwin(Twin):
    """Eq. (4) of Li et al. 2022 as printed, by classical Runge-Kutta steps in H."""

    def __init__(self, model: JilesAtherton, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        self.unit = 180 / math.pi if model.angle_unit == "deg" else 1.0

    def equation(self, H: float, M: float, delta: float) -> float:
        """Returns dM/dH in the unit of the parameters."""
        Ms, a, alpha, c, k = (getattr(self.model, name) for name in ("Ms", "a", "alpha", "c", "k"))
        L, dL = langevin((H + alpha * M) / a)
        numerator = Ms * L - M + c * delta * k * Ms / a * dL
        return numerator / (delta * k - alpha * numerator)

    def _torque_after(self, angle: float) -> float:
        H, end = self.angle * self.unit, angle * self.unit
        steps = math.ceil(abs(angle - self.angle) * 180 / math.pi / FIELD_STEP)
        h, M = (end - H) / steps, self.torque
        for i in range(steps):
            M = runge_kutta(self.equation, H + i * h, M, h)
        return M

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] of the branch from here."""
        return self.equation(angle * self.unit, torque, delta) * self.unit


def langevin(x: float) -> tuple[float, float]:
    """Returns L(x) = coth x - 1/x and L'(x); the series near 0, where the closed forms cancel."""
    if abs(x) < 0.05:
        L = x / 3 - x**3 / 45 + 2 * x**5 / 945 - x**7 / 4725
        return L, 1 / 3 - x**2 / 15 + 2 * x**4 / 189 - x**6 / 675
    return 1 / math.tanh(x) - 1 / x, 1 / x**2 - 1 / math.sinh(x) ** 2


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


class BoucWenTwin(Twin):
    """The differential equation of z as printed in `BoucWen`, by classical Runge-Kutta steps."""

    def __init__(self, model: BoucWen, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.model = model
        self.z = self.z_of(self.angle, self.torque)

    def z_of(self, angle: float, torque: float) -> float:
        """Returns z [rad], read back from the torque."""
        elastic = self.model.elastic * (angle - self.model.rest_angle)
        return (torque - elastic) / self.model.hysteretic

    def equation(self, _: float, z: float, delta: float) -> float:
        """Returns dz/dtheta."""
        m = self.model
        return m.A - delta * m.beta * abs(z) ** (m.n - 1) * z - m.gamma * abs(z) ** m.n

    def step(self, z: float, h: float) -> float:
        """Returns z after a small motion h; z = 0, where the equation bends, is approached."""
        after = runge_kutta(self.equation, 0.0, z, h)
        if z * after < 0 and abs(h) > 1e-9:
            return self.step(self.step(z, h / 2), h / 2)
        return after

    def _torque_after(self, angle: float) -> float:
        steps = math.ceil(abs(angle - self.angle) / ANGLE_STEP)
        for _ in range(steps):
            self.z = self.step(self.z, (angle - self.angle) / steps)
        return self.model.elastic * (angle - self.model.rest_angle) + self.model.hysteretic * self.z

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] of the branch from here."""
        dz = self.equation(angle, self.z_of(angle, torque), delta)
        return self.model.elastic + self.model.hysteretic * dz

    def knots(self, end: float) -> list[float]:
        """Returns the angle [rad] at which z is zero."""
        angle, z, h = self.angle, self.z, math.copysign(ANGLE_STEP, end - self.angle)
        while z * h < 0 < (end - angle) * h and abs(h) > 1e-12:
            after = runge_kutta(self.equation, 0.0, z, h)
            if z * after < 0:
                h /= 2
            else:
                angle, z = angle + h, after
        return [angle]


class PrandtlIshlinskiiTwin(Twin):
    """A list of stops, all at zero in the beginning; a play is what a stop leaves of the angle."""

    def __init__(self, model: PrandtlIshlinskii, angles: Array, _: float) -> None:
        self.model = model
        self.stops = [0.0 for _ in model.thresholds]
        super().__init__(angles[0], self.sum(angles[0]))

    def sum(self, angle: float) -> float:
        """Returns the torque [N·m] at `angle` with the stops as they are."""
        u = angle - self.model.rest_angle
        parts = [stop if self.model.operator == "stop" else u - stop for stop in self.stops]
        pairs = zip(self.model.weights, parts, strict=True)
        return self.model.stiffness * u + sum(weight * part for weight, part in pairs)

    def _torque_after(self, angle: float) -> float:
        pairs = zip(self.stops, self.model.thresholds, strict=True)
        self.stops = [min(max(stop + angle - self.angle, -r), r) for stop, r in pairs]
        return self.sum(angle)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] of the branch from here."""
        moved, total = abs(angle - self.angle), self.model.stiffness
        parts = zip(self.model.weights, self.model.thresholds, self.stops, strict=True)
        for weight, r, stop in parts:
            slips = delta * stop + moved >= r
            total += weight if slips == (self.model.operator == "play") else 0.0
        return total

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] at which a stop begins to slip."""
        delta = math.copysign(1.0, end - self.angle)
        pairs = zip(self.stops, self.model.thresholds, strict=True)
        return [self.angle + delta * r - stop for stop, r in pairs]


class PreisachTwin(Twin):
    """The half plane of relays cut into patches, and the share of each patch that is up.

    Levels and turning points of the whole motion cut, so that at a turn each patch is up or down as
    one. Between turns the shares are exact areas: of a rectangle, or of the triangle that a patch
    on the diagonal is.
    """

    def __init__(self, model: Preisach, angles: Array, torque: float) -> None:
        levels = self.levels = np.array(model.levels)
        self.elastic_slopes = np.array(model.elastic)
        cuts = np.clip(angles[[0, *turn_indices(angles)]], levels[0], levels[-1])
        self.grid = np.unique([*levels, *cuts])
        width = np.diff(self.grid)
        cell = np.searchsorted(levels, self.grid[:-1], side="right") - 1
        part = width / np.diff(levels)[cell]
        row, column = np.tril_indices(width.size)  # up-switching, down-switching
        weight = [model.density[i][j] for i, j in zip(cell[row], cell[column], strict=True)]
        # A cell on the diagonal is a triangle: patches in it have twice the share, or are halves.
        whole = np.where(cell[row] == cell[column], 2.0, 1.0) * np.where(row == column, 0.5, 1.0)
        self.weight = np.array(weight) * part[row] * part[column] * whole
        self.power = np.where(row == column, 2, 1)
        self.up_from, self.down_from = self.grid[row], self.grid[column + 1]
        self.up_width, self.down_width = width[row], width[column]
        self.up = self.risen(angles[0])
        self.offset = torque - self.elastic(angles[0]) + self.weight @ self.up
        super().__init__(angles[0], torque)

    def risen(self, angle: float) -> Array:
        """Returns the share of each patch that a rise to `angle` from far below switches up."""
        return np.clip((angle - self.up_from) / self.up_width, 0, 1) ** self.power

    def fallen(self, angle: float) -> Array:
        """Returns the share of each patch that a fall to `angle` from far above switches down."""
        return np.clip((self.down_from - angle) / self.down_width, 0, 1) ** self.power

    def elastic(self, angle: float) -> float:
        """Returns the torque [N·m] of the elastic part, from 0 at the lowest level."""
        ends = [-math.inf, *self.levels[1:-1], math.inf]
        pieces = zip(self.elastic_slopes, pairwise(ends), strict=True)
        start = self.levels[0]
        return sum(k * (min(max(angle, a), b) - max(a, start)) for k, (a, b) in pieces)

    def _torque_after(self, angle: float) -> float:
        if angle > self.angle:
            self.up = np.maximum(self.up, self.risen(angle))
        else:
            self.up = np.minimum(self.up, 1 - self.fallen(angle))
        return float(self.offset + self.elastic(angle) - self.weight @ self.up)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] of the branch from here."""
        if delta > 0:
            way, width, able = angle - self.up_from, self.up_width, 1 - self.up
        else:
            way, width, able = self.down_from - angle, self.down_width, self.up
        switching = (0 < way) & (way < width)
        share = self.power * (way / width) ** (self.power - 1) / width
        i = np.clip(np.searchsorted(self.levels, angle) - 1, 0, self.levels.size - 2)
        return float(self.elastic_slopes[i] - self.weight @ (switching * share * able))

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] at which patches end."""
        return self.grid.tolist()


class AsymmetricTwin(Twin):
    """Another twin beside a polynomial."""

    def __init__(self, model: Asymmetric, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.coefficients = [float(p) for p in model.polynomial]
        self.inner = twin_of(model.model, angles, torque - self.polynomial(self.angle))

    def polynomial(self, angle: float) -> float:
        """Returns the elastic torque [N·m]."""
        return sum(p * angle**i for i, p in enumerate(self.coefficients))

    def _torque_after(self, angle: float) -> float:
        return self.inner.move(angle) + self.polynomial(angle)

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] of the branch from here."""
        bend = sum(i * p * angle ** (i - 1) for i, p in enumerate(self.coefficients) if i)
        return self.inner.slope(angle, torque - self.polynomial(angle), delta) + bend

    def knots(self, end: float) -> list[float]:
        """Returns the angles [rad] of the inner twin."""
        return self.inner.knots(end)


class HeldTwin(Twin):
    """Another twin that is asked for no angle outside a range."""

    def __init__(self, model: Held, angles: Array, torque: float) -> None:
        super().__init__(angles[0], torque)
        self.range = model.angle_range
        self.inner = twin_of(model.model, np.clip(angles, *self.range), torque)

    def _torque_after(self, angle: float) -> float:
        return self.inner.move(float(np.clip(angle, *self.range)))

    def slope(self, angle: float, torque: float, delta: float) -> float:
        """Returns dT/dtheta [N·m/rad] of the branch from here."""
        inside = self.range[0] < angle < self.range[1]
        return self.inner.slope(angle, torque, delta) if inside else 0.0

    def knots(self, end: float) -> list[float]:
        """Returns the ends of the range and the angles [rad] of the inner twin."""
        return [*self.range, *self.inner.knots(end)]


TWINS: dict[type[HysteresisModel], Callable[..., Twin]] = {
    JilesAtherton: JilesAthertonTwin,
    BoucWen: BoucWenTwin,
    PrandtlIshlinskii: PrandtlIshlinskiiTwin,
    Preisach: PreisachTwin,
    Held: HeldTwin,
    Asymmetric: AsymmetricTwin,
}


def twin_of(model: HysteresisModel, angles: Array, torque: float) -> Twin:
    """Returns a model's twin at angles[0] [rad], where the torque is known [N·m].

    The twin of Jiles-Atherton is that of form `bulk` without a clamp.
    """
    return TWINS[type(model)](model, angles, torque)


def turn_indices(angles: Array) -> NDArray[np.intp]:
    """Returns the samples at which a motion turns, and its last."""
    moved = np.flatnonzero(np.diff(angles, prepend=math.inf))
    turned = np.diff(np.sign(np.diff(angles[moved])))
    return np.append(moved[1:-1][turned != 0], angles.size - 1)
