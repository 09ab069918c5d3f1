"""The basic particle swarm, of Li et al. 2022, section 4.1, and of Kao and Fung 2009, eq. (3)-(4).

The two differ in coefficients and in what is drawn once per particle or once per dimension:
`pso(objective, bounds)` is the first, `pso(objective, bounds, **KAO_FUNG)` the second.
"""

import math
from typing import Literal, TypedDict, Unpack

from scipy.optimize import OptimizeResult

from ...errors import InputError
from ...published import KAO_COGNITIVE, KAO_INERTIA, KAO_SOCIAL
from .swarm import Bounds, Callback, Objective, Swarm, SwarmOptions

Inertia = Literal["tanh", "linear"] | float
TANH_RANGE = (0.95, 0.4)  # inertia at the first move and at the last
LINEAR_RANGE = (0.9, 0.4)
LEARNING_FACTOR = 2.0  # c1 = c2 of Li et al. 2022


class Coefficients(TypedDict):
    """The options of `pso` in which the two papers differ."""

    inertia: Inertia
    cognitive: float
    social: float
    per_dimension: bool


# What Kao and Fung 2009 identify with; their eq. (4) is inertia="linear".
KAO_FUNG = Coefficients(
    inertia=KAO_INERTIA, cognitive=KAO_COGNITIVE, social=KAO_SOCIAL, per_dimension=True
)


def tanh_inertia(iteration: int, iterations: int) -> float:
    """Inertia falling along a tanh from 0.95 to 0.4, eq. (10) of Li et al. 2022."""
    first, last = TANH_RANGE
    mean, half = (first + last) / 2, (first - last) / 2
    return math.tanh(-5 + 10 * (iterations - iteration) / iterations) * half + mean


def linear_inertia(iteration: int, iterations: int) -> float:
    """Inertia falling from 0.9 to 0.4: eq. (13) of Li et al. 2022, (4) of Kao and Fung 2009."""
    first, last = LINEAR_RANGE
    return first - (first - last) * iteration / iterations


class PSO(Swarm):
    """The basic swarm as an ask/tell core.

    Args:
        bounds: One pair (low, high) per parameter.
        inertia: Inertia of the velocity: "tanh", "linear" or a constant.
        cognitive: Coefficient c1, the pull towards a particle's own best.
        social: Coefficient c2, the pull towards the best of all.
        per_dimension: Whether random numbers are drawn for each dimension of each particle.
        **common: Options that every swarm takes; `SwarmOptions` lists them.
    """

    def __init__(
        self,
        bounds: Bounds,
        *,
        inertia: Inertia = "tanh",
        cognitive: float = LEARNING_FACTOR,
        social: float = LEARNING_FACTOR,
        per_dimension: bool = False,
        **common: Unpack[SwarmOptions],
    ) -> None:
        super().__init__(bounds, **common)
        if inertia not in ("tanh", "linear") and not _usable(inertia):
            raise InputError(f"inertia is {inertia!r}: use 'tanh', 'linear' or a number from 0")
        for name, value in (("cognitive", cognitive), ("social", social)):
            if not _usable(value):
                raise InputError(f"{name} is {value!r}: use a finite number from 0")
        self._inertia: Inertia = inertia
        self._cognitive, self._social = cognitive, social
        if per_dimension:
            self._draws = (2, *self._position.shape)
        self._options |= Coefficients(
            inertia=inertia, cognitive=cognitive, social=social, per_dimension=per_dimension
        )

    def _coefficients(self) -> tuple[float, float, float]:
        if self._inertia == "tanh":
            inertia = tanh_inertia(self.iteration, self._max_iterations)
        elif self._inertia == "linear":
            inertia = linear_inertia(self.iteration, self._max_iterations)
        else:
            inertia = float(self._inertia)
        return inertia, self._cognitive, self._social


def pso(
    objective: Objective,
    bounds: Bounds,
    *,
    inertia: Inertia = "tanh",
    cognitive: float = LEARNING_FACTOR,
    social: float = LEARNING_FACTOR,
    per_dimension: bool = False,
    callback: Callback | None = None,
    **common: Unpack[SwarmOptions],
) -> OptimizeResult:
    """Minimizes with the basic swarm: eq. (5), (6), (8)-(10) of Li et al. 2022.

    `PSO` is the same as an ask/tell core that can be saved and resumed.

    Args:
        objective: Function that maps positions (n, d) to values (n,); a value that is not finite
            discards that position.
        bounds: One pair (low, high) per parameter; a particle beyond is set back to the bound and
            keeps its velocity.
        inertia: Inertia of the velocity: "tanh", eq. (10); "linear", from 0.9 to 0.4; or a
            constant.
        cognitive: Coefficient c1, the pull towards a particle's own best.
        social: Coefficient c2, the pull towards the best of all.
        per_dimension: Whether the random numbers of eq. (8) are drawn for each dimension of each
            particle, as eq. (3) of Kao and Fung 2009 does, instead of once per particle.
        callback: Function that gets the intermediate result after every iteration; it may raise
            StopIteration.
        **common: Options that every swarm takes; `SwarmOptions` lists them.

    Returns:
        A result with `x`, `fun`, `nit`, `nfev`, `history` (best value before the first and after
        each iteration), `discarded`, `population`, `success`, `message`.
    """
    swarm = PSO(
        bounds,
        inertia=inertia,
        cognitive=cognitive,
        social=social,
        per_dimension=per_dimension,
        **common,
    )
    return swarm.minimize(objective, callback)


def _usable(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value) and value >= 0
