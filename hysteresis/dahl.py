"""A nonlinear spring beside Dahl's friction: the least memory that a suit can have."""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial as poly

from ..arrays import Array

ANGLE, FRICTION, MEMORY = 0, 1, 2
DEGREE = 3


@dataclass(frozen=True)
class Dahl:
    """A polynomial of the angle and one state of friction.

        T = p(theta) + z,    dz = stiffness (1 - sign(dtheta) z / friction) dtheta

    Dahl 1968, "A solid friction model"; the state has an exact solution along a monotone motion.

    Attributes:
        spring: Coefficients of p, constant first [N·m/rad^i].
        stiffness: Slope dz/dtheta at z = 0 [N·m/rad].
        friction: Greatest z [N·m].
        start_angle: Angle at which motions begin [rad], with z = 0.
    """

    spring: tuple[float, ...]
    stiffness: float
    friction: float
    start_angle: float = 0.0

    memory_size = MEMORY

    def response(self, angle: Array) -> Array:
        """Returns the torque along angles [rad], shape (n,) [N·m]."""
        memory, torque = self.begin()[None], np.empty(len(angle))
        for i, here in enumerate(angle):
            torque[i] = self.advance(memory, here[None], here[None])[0]
        return torque

    def begin(self) -> Array:
        """Returns the memory at the start: the last angle and the friction, shape (2,)."""
        return np.array([self.start_angle, 0.0])

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves memories on, in place; see `HysteresisModel.advance`."""
        memories[:, FRICTION] = self._moved(memories[:, FRICTION], angle - memories[:, ANGLE])
        memories[:, ANGLE] = angle
        ahead = self._moved(memories[:, FRICTION], soon - angle)
        return poly.polyval(soon, self.spring) + ahead

    def _moved(self, friction: Array, way: Array) -> Array:
        """Returns the friction after a motion [rad] from some friction [N·m]."""
        limit = np.sign(way) * self.friction
        decay = np.exp(-self.stiffness * np.abs(way) / self.friction)
        return np.where(way == 0, friction, limit + (friction - limit) * decay)


def fit_dahl(angle: Array, torque: Array) -> Dahl:
    """Returns the least-squares fit to measured torques along a motion.

    Args:
        angle: Angles [rad], shape (n,).
        torque: Torques [N·m], the same shape.
    """
    from scipy.optimize import least_squares  # slow to import

    powers, start = poly.polyvander(angle, DEGREE), float(angle[0])

    def friction_of(numbers: Array) -> Array:
        stiffness, friction = np.exp(numbers)
        return Dahl((0.0,), float(stiffness), float(friction), start).response(angle)

    def rest(numbers: Array) -> Array:
        left = torque - friction_of(numbers)
        return powers @ np.linalg.lstsq(powers, left, rcond=None)[0] - left

    scale, reach = float(np.ptp(torque)), float(np.ptp(angle))
    guesses = [np.log([scale / (share * reach), scale / 4]) for share in (0.05, 0.2, 0.8)]
    found = min((least_squares(rest, guess) for guess in guesses), key=lambda one: one.cost).x
    spring = np.linalg.lstsq(powers, torque - friction_of(found), rcond=None)[0]
    stiffness, friction = np.exp(found).tolist()
    return Dahl(tuple(spring.tolist()), stiffness, friction, start)
