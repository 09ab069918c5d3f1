"""A readable reference of the Preisach model, and examples of the model."""

import math
from itertools import pairwise

import numpy as np

from ...arrays import Array
from ..preisach.model import Preisach
from .reference import Example, Reference, refers_to, turn_indices

SEED = 1


@refers_to(Preisach)
class PreisachReference(Reference):
    """The half plane of relays cut into patches, and the share of each patch that is up.

    The cuts are the levels and all turning points of the motion, so that at each turn a patch is
    either all up or all down. Between turns the shares are exact areas, of a rectangle or, for a
    patch on the diagonal, of a triangle.
    """

    def __init__(self, model: Preisach, angles: Array, torque: float) -> None:
        levels = self.levels = np.array(model.levels)
        self.elastic_slopes = np.array(model.elastic)
        cuts = np.clip(angles[[0, *turn_indices(angles)]], levels[0], levels[-1])
        self.grid = np.unique([*levels, *cuts])
        width = np.diff(self.grid)
        cell = np.searchsorted(levels, self.grid[:-1], side="right") - 1
        part = width / np.diff(levels)[cell]
        row, column = np.tril_indices(width.size)  # levels of switching up and down
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
        """Returns dT/dtheta [N·m/rad] on the present branch; see `Reference.slope`."""
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


def _random() -> Preisach:
    rng = np.random.default_rng(SEED)
    density = [rng.uniform(0, 0.3, i + 1).tolist() for i in range(8)]
    return Preisach(levels=np.linspace(0, 2, 9), density=density, elastic=rng.uniform(1, 6, 8))


EXAMPLES = (Example(name="preisach", model=_random(), low=-0.2, high=2.2, start_torque=0.3),)
