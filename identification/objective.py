"""How far a model is from measured curves: the paper's fitness and the NRMSE."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..hysteresis import _jiles_atherton_kernels as kernels
from .curves import Curve


@dataclass(eq=False)
class CurveObjective:
    """Fitness of Jiles-Atherton parameters on a family of curves, for whole populations at once.

    Rows of parameters are (Ms, a, alpha, c, k) with a, k, alpha in degrees, the unit of the
    paper's Tables 1 and 2. Each curve starts with zero torque, as a first-order transition curve
    does by definition. Parameters whose curve meets the pole score infinity.

    Attributes:
        curves: the measured curves.
        evaluations: how many parameter rows have been scored so far.
    """

    curves: Sequence[Curve]
    evaluations: int = 0
    torque: NDArray[np.float64] = field(init=False)
    peak: float = field(init=False)

    def __post_init__(self) -> None:
        if not self.curves:
            raise InputError("there is no curve to fit: give at least one with role 'fit'")
        self.torque = np.concatenate([curve.torque for curve in self.curves])
        self.peak = float(np.abs(self.torque).max())
        if self.peak == 0:
            raise InputError("every torque is zero: there is nothing to identify")
        self._angle = np.degrees(np.concatenate([curve.angle for curve in self.curves]))
        self._starts = np.cumsum([0] + [curve.angle.size for curve in self.curves])
        self._initial = np.zeros(len(self.curves))

    def responses(self, parameters: ArrayLike) -> NDArray[np.float64]:
        """Returns the torque of each parameter row along all curves, shape (n, samples) [N·m]."""
        parameters = np.atleast_2d(np.asarray(parameters, dtype=np.float64))
        self.evaluations += len(parameters)
        torque = np.empty((len(parameters), self._angle.size))
        kernels.population_response(self._angle, self._starts, self._initial, parameters, torque)
        return torque

    def nrmse(self, parameters: ArrayLike) -> NDArray[np.float64]:
        """Returns sqrt(mean((Tc - Tm)^2)) / max|Tm| of each parameter row, shape (n,)."""
        errors = self.responses(parameters)
        errors -= self.torque
        score = np.sqrt(np.einsum("ij,ij->i", errors, errors) / self.torque.size) / self.peak
        return np.where(np.isfinite(score), score, np.inf)

    def __call__(self, parameters: ArrayLike) -> NDArray[np.float64]:
        """Returns the paper's fitness, eq. (7): sqrt(sum(((Tc - Tm) / Tmax)^2)) / N, shape (n,)."""
        return self.nrmse(parameters) / np.sqrt(self.torque.size)
