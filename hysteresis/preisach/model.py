"""The Preisach model: a continuum of relays that switch at two angles each."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import ModuleType
from typing import ClassVar

import numpy as np

from ...arrays import Array
from ...checks import numbers
from ...errors import InputError, shown
from ..certificate import ALL_ANGLES, Certificate, checked_range
from ..protocol import ConfigKey, HysteresisModel, Numbers, read_only
from . import kernels


@dataclass(frozen=True, kw_only=True)
class Preisach(HysteresisModel):
    """Resistance T of a joint as an elastic part less the weights of the relays that are up.

        T = offset + elastic(theta) - sum of the weights of all relays that are up

    A relay (alpha, beta), alpha >= beta, goes up where a rising angle passes alpha and down where
    a falling one passes beta. Between the levels the relays fill the half plane with a density
    that is uniform in each cell (Mayergoyz, Mathematical Models of Hysteresis, 1991, ch. I). The
    minus sign makes positive weights resist: just after a turn no relay switches and the joint is
    as stiff as its elastic part, then relay after relay gives way. On a branch from a turn at t,
    the relays in the triangle between t and theta have switched; their weight, the Everett function
    E(max, min), is a closed form in each cell. So the memory is the turning points alone.

    Memory. A motion starts as if the angle had come up from below the lowest level; the torque
    there fixes the offset, since a measured family of curves has no absolute zero. (Relays that
    reach below the start are the reason why a first loop may not close.) A loop that closes leaves
    no trace; loops between the same angles are congruent. Beyond the levels no relay switches, and
    the elastic part continues with the slope of its end segment. At most 64 nested turning points
    are kept: the joint then follows the innermost branch back and forth without loss, and the loss
    of that branch counts when the motion leaves the branch.

    Energy. Let a relay of weight w and middle m = (alpha + beta) / 2 store w (m - theta) while up
    and nothing while down. The slope of the stored energy is the relay's torque, -w or 0; at either
    switch, up at alpha or down at beta, the stored energy drops by w (alpha - beta) / 2, which the
    switch dissipates, and which is not negative if w >= 0. Summed over the relays,

        dissipated = sum of w (alpha - beta) / 2 over all switches since the start
        stored     = (T - elastic) (theta - level 0) + energy of the elastic part
                     + sum of w (m - level 0) over the relays that are up

    where `stored` is a function of the state, and both together change by the work of T. Both sums
    are closed forms in each cell, as E is.

    Attributes:
        levels: Increasing angles that divide the range into n segments [rad], n + 1 >= 2 numbers.
        density: Weights [N·m] in n rows: entry j of row i, j <= i, is the weight of all relays with
            alpha in segment i and beta in segment j, by which the torque drops when all these
            relays go up. The model is dissipative if no weight is below 0.
        elastic: Slope of the elastic part in each segment [N·m/rad], of any sign; by default 0.
    """

    name: ClassVar[str] = "preisach"
    kernels: ClassVar[ModuleType] = kernels
    config_keys: ClassVar[tuple[ConfigKey, ...]] = (
        ConfigKey("levels", "list"),
        ConfigKey("density", "rows"),
        ConfigKey("elastic", "list", optional=True),
    )
    not_fitted: ClassVar[tuple[str, ...]] = ("levels",)
    least: ClassVar[Mapping[str, float]] = {"density": 0.0}
    units: ClassVar[Mapping[str, str]] = {"levels": "rad", "density": "N·m", "elastic": "N·m/rad"}

    levels: Numbers
    density: Sequence[Numbers]
    elastic: Numbers = ()

    def __post_init__(self) -> None:
        if len(numbers("levels", self.levels, "rad")) < 2:
            raise InputError(f"levels is {shown(self.levels)}: give at least 2 angles (rad)")
        super().__post_init__()
        if np.any(np.diff(self.levels) <= 0):
            raise self._wrong("levels", "give increasing numbers")
        segments = len(self.levels) - 1
        if len(self.density) != segments:
            raise self._wrong("density", f"give {segments} rows, one for each segment of levels")
        if len(self.elastic) not in (0, segments):
            raise self._wrong("elastic", "give as many numbers as segments between levels")
        if not self.elastic:
            object.__setattr__(self, "elastic", (0.0,) * len(self.density))

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters as the kernels read them, with sums over the cells of the density."""
        p = np.empty(kernels.parameter_size.py_func(len(self.density)))
        density = np.concatenate(self.density)
        kernels.set_parameters(p, np.array(self.levels), density, np.array(self.elastic))
        return read_only(p)

    def everett(self, alpha: float, beta: float) -> float:
        """Returns E(alpha, beta): the weight [N·m] of all relays between two angles [rad]."""
        p = self._parameters
        high, low = np.clip([alpha, beta], self.levels[0], self.levels[-1])
        return float(self.kernels.swept(p, high, low)[0])

    def certificate(self, angle_range: tuple[float, float] = ALL_ANGLES) -> Certificate:
        """Returns the certificate for every motion in a range of angles [rad], from every start.

        No stiffness is infinite, since the density is bounded. The model is dissipative if no
        weight is below 0, by the energy in the docstring of the class. The torque bound is the
        spread of the elastic part, plus the sum of |weight| of all relays that go up inside the
        range. The bound holds for |T - T(start)|, since the offset is free.
        """
        low, high = checked_range(angle_range)
        sizes = replace(self, density=[[abs(weight) for weight in row] for row in self.density])
        switching = sizes.everett(high, -math.inf) - sizes.everett(low, -math.inf)
        return Certificate(
            margin=1.0,
            dissipative=all(weight >= 0 for row in self.density for weight in row),
            torque_bound=self._elastic_spread(low, high) + switching,
            angle_range=(low, high),
        )

    def _elastic_spread(self, low: float, high: float) -> float:
        if (low == -math.inf and self.elastic[0]) or (high == math.inf and self.elastic[-1]):
            return math.inf
        angles = [*np.clip(self.levels, low, high), *filter(math.isfinite, (low, high))]
        return float(np.ptp([self.kernels.elastic(self._parameters, x)[0] for x in angles]))

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory that continues another model's.

        The turning points stay, and the torque with all relays down stays as a share of the sum of
        all |weights|.
        """
        old, new = kernels.total_weight(parameters), kernels.total_weight(self.parameter_vector)
        down, turns = kernels.RECORDS, kernels.turning_points(memory)
        below = float(memory[down + 1]) * (new / old if old > 0 else 1.0)
        lowest = self.levels[0]
        own = self.start(lowest, below).memory.copy()
        for angle in [*memory[down + 2 : down + 2 * turns + 2 : 2], memory[0]]:
            kernels.commit(self._parameters, own, angle)
        return self._keep_loss(own, memory, parameters)
