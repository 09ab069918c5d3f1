"""Curves without memory: one polynomial for rising and one for falling angles."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial as poly

from ..arrays import Array


@dataclass(frozen=True)
class Branches:
    """A resistance that depends on the angle and on the direction of motion alone.

    Examples are a straight spring, a spring with Coulomb friction, and a polynomial for each branch
    of the loop. The torque jumps at a reversal, so these curves cannot simulate a suit.

    Attributes:
        rising: Coefficients of the torque while the angle rises, constant first [N·m/rad^i].
        falling: Coefficients of the torque while the angle falls, constant first [N·m/rad^i].
    """

    rising: tuple[float, ...]
    falling: tuple[float, ...]

    def torque(self, angle: Array, direction: Array) -> Array:
        """Returns the torque [N·m] at angles [rad] for the sign of the motion, 1 or -1."""
        up, down = poly.polyval(angle, self.rising), poly.polyval(angle, self.falling)
        return np.where(direction > 0, up, down)

    def response(self, angle: Array) -> Array:
        """Returns the torque along angles [rad], shape (n,); the first motion counts as rising."""
        return self.torque(angle, _direction(angle))


def spring(angle: Array, torque: Array) -> Branches:
    """Returns the straight line through measured torques [N·m] at angles [rad], shape (n,)."""
    line = tuple(poly.polyfit(angle, torque, 1).tolist())
    return Branches(line, line)


def spring_with_friction(angle: Array, torque: Array) -> Branches:
    """Returns the straight line with a Coulomb friction beside it."""
    way = _direction(angle)
    columns = np.stack([np.ones_like(angle), angle, way], axis=1)
    offset, slope, friction = np.linalg.lstsq(columns, torque, rcond=None)[0].tolist()
    return Branches((offset + friction, slope), (offset - friction, slope))


def two_branches(angle: Array, torque: Array) -> Branches:
    """Returns one cubic for the rising and one for the falling branch of all loops."""
    way = _direction(angle)
    up, down = (poly.polyfit(angle[way == s], torque[way == s], 3) for s in (1.0, -1.0))
    return Branches(tuple(up.tolist()), tuple(down.tolist()))


def _direction(angle: Array) -> Array:
    """Returns the sign of the motion at each sample; a pause keeps the previous sign."""
    way = np.sign(np.diff(angle, prepend=angle[0]))
    last = np.maximum.accumulate(np.where(way != 0, np.arange(way.size), 0))
    found = way[last]
    return np.where(found == 0, 1.0, found)
