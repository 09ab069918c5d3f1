"""The published swarms, and the optimizers by name."""

import inspect
import math
from abc import ABC
from collections.abc import Callable
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ...published import KAO_COGNITIVE, KAO_INERTIA, KAO_SOCIAL
from .swarm import Bounds, Callback, Objective, Swarm

Inertia = Literal["tanh", "linear"] | float
TANH_RANGE = (0.95, 0.4)  # inertia at the first move and at the last
LINEAR_RANGE = (0.9, 0.4)
LEARNING_FACTOR = 2.0  # c1 = c2 of Li et al. 2022
COGNITIVE_FIRST, COGNITIVE_LAST = 2.5, 1.3
SOCIAL_FIRST, SOCIAL_LAST = 0.5, 1.7
COOLING = 0.95
Temperature = Literal["paper", "ln5"] | float
DIVISORS = {"paper": math.exp(-10), "ln5": math.log(5)}
DECAY_MAX, DECAY_MIN = 0.7, 0.005  # rho_max, rho_min
REGULATING_SCALE = 1.25  # R
DistanceRank = Literal["far", "near"]
Optimizer = Callable[..., OptimizeResult]
NO_SEARCHES = ("auto", "certified", "magnetic")  # methods of `identify` that no optimizer may hide


# What Kao and Fung 2009 identify with; their eq. (4) is inertia="linear".
KAO_FUNG: dict[str, Any] = {
    "inertia": KAO_INERTIA,
    "cognitive": KAO_COGNITIVE,
    "social": KAO_SOCIAL,
    "per_dimension": True,
}


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
    """The basic swarm: eq. (5), (6), (8)-(10) of Li et al. 2022.

    Args:
        bounds: One pair (low, high) per parameter.
        inertia: Inertia of the velocity: "tanh", eq. (10) of Li et al. 2022; "linear", from 0.9 to
            0.4; or a constant.
        cognitive: Coefficient c1, the pull towards a particle's own best.
        social: Coefficient c2, the pull towards the best of all.
        per_dimension: Whether the random numbers of eq. (8) are drawn for each dimension of each
            particle, as eq. (3) of Kao and Fung 2009 does, instead of once per particle.
        **common: Options of `Swarm`.
    """

    def __init__(
        self,
        bounds: Bounds,
        *,
        inertia: Inertia = "tanh",
        cognitive: float = LEARNING_FACTOR,
        social: float = LEARNING_FACTOR,
        per_dimension: bool = False,
        **common: Any,
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

    def _coefficients(self) -> tuple[float, float, float]:
        if self._inertia == "tanh":
            inertia = tanh_inertia(self.iteration, self._max_iterations)
        elif self._inertia == "linear":
            inertia = linear_inertia(self.iteration, self._max_iterations)
        else:
            inertia = float(self._inertia)
        return inertia, self._cognitive, self._social


def _usable(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value) and value >= 0


def scheduled_coefficients(iteration: int, iterations: int) -> tuple[float, float, float]:
    """Linear inertia, eq. (13), and learning factors, eq. (14).

    The "A" of eq. (14) is taken for the inertia Lambda(n) of eq. (13): only then c1, c2 run from
    (2.5, 0.5) to exactly (1.3, 1.7).
    """
    first, last = LINEAR_RANGE
    inertia = linear_inertia(iteration, iterations)
    relative = (inertia - last) / (first - last)
    share = math.exp(-70 * relative**6)
    cognitive = COGNITIVE_FIRST - (COGNITIVE_FIRST - COGNITIVE_LAST) * share
    social = SOCIAL_FIRST - (SOCIAL_FIRST - SOCIAL_LAST) * share
    return inertia, cognitive, social


class MPSO(Swarm):
    """MPSO: eq. (13) and (14) of Li et al. 2022 on the basic swarm, with the options of `Swarm`."""

    def _coefficients(self) -> tuple[float, float, float]:
        return scheduled_coefficients(self.iteration, self._max_iterations)


class SAPSO(Swarm):
    """SA-PSO: eq. (5), (6), (8)-(12) and steps 1-12 of Li et al. 2022.

    In each iteration one random number picks, by the roulette of eq. (12), the personal best that
    the whole swarm follows; the best point ever found is kept apart and returned.

    Args:
        bounds: One pair (low, high) per parameter.
        temperature: First temperature, as the best fitness divided by a number: "paper" is eq. (11)
            as printed, F / e^-10, which is so hot that the roulette stays uniform for all 100
            iterations; "ln5" is F / ln 5, the textbook rule; a number divides by that number.
        **common: Options of `Swarm`.
    """

    def __init__(
        self, bounds: Bounds, *, temperature: Temperature = "paper", **common: Any
    ) -> None:
        super().__init__(bounds, **common)
        self._divisor = _divisor(temperature)
        self._first_temperature = 0.0

    def _coefficients(self) -> tuple[float, float, float]:
        inertia = tanh_inertia(self.iteration, self._max_iterations)
        return inertia, LEARNING_FACTOR, LEARNING_FACTOR

    def _leader(self) -> int:
        """Draws the leader by eq. (11) and (12): one random number for the whole swarm."""
        if self.iteration == 0:
            self._first_temperature = float(self._personal_fitness.min()) / self._divisor
        temperature = self._first_temperature * COOLING**self.iteration
        share = selection_probability(self._personal_fitness, temperature)
        drawn = int(np.searchsorted(np.cumsum(share), self._rng.random()))
        return min(drawn, share.size - 1)


def selection_probability(fitness: Array, temperature: float) -> Array:
    """Returns the probability of each particle to lead, eq. (12), (n,); if cold, the best leads."""
    if temperature <= 0:
        return (np.arange(fitness.size) == np.argmin(fitness)).astype(np.float64)
    weight = np.exp(-(fitness - fitness.min()) / temperature)
    return weight / weight.sum()


def _divisor(temperature: Temperature) -> float:
    divisor = (
        DIVISORS.get(temperature, temperature) if isinstance(temperature, str) else temperature
    )
    if isinstance(divisor, str) or not (math.isfinite(divisor) and divisor > 0):
        raise InputError(f"temperature is {temperature!r}: use 'paper', 'ln5' or a divisor above 0")
    return divisor


class RankDistanceMPSO(PSO):
    """The modified swarm of Kao and Fung 2009: eq. (3)-(9).

    An individual is a particle with its position, velocity and personal best. `ask` returns the
    offspring, the particles one move later; `tell` keeps, of parents and offspring together, the
    half with the lowest sum of error rank and decayed distance rank, and always the best one. The
    paper leaves open, and here is chosen: survivors keep their velocity and personal best,
    distances are measured in units of the box, and ranks start at 1 with ties in order, parents
    first. The `population` of a result is the survivors.

    Args:
        bounds: One pair (low, high) per parameter.
        distance_rank: Individual with the best distance rank, 1: "far", the farthest from the best
            solution, as in the paper's figure 4; or "near", the nearest, as in the paper's words "a
            higher rank to a longer distance".
        patience: Number of iterations in a row without a better value that ends the run: the
            paper's second stop rule, without its number. None: no such rule.
        **options: Options of `PSO`, by default `KAO_FUNG`.
    """

    def __init__(
        self,
        bounds: Bounds,
        *,
        distance_rank: DistanceRank = "far",
        patience: int | None = None,
        **options: Any,
    ) -> None:
        super().__init__(bounds, **{**KAO_FUNG, **options})
        if distance_rank not in ("far", "near"):
            raise InputError(f"distance_rank is {distance_rank!r}: use 'far' or 'near'")
        if patience is not None:
            at_least("patience", patience, 1)
        self._far_first, self._patience = distance_rank == "far", patience
        self._parent_position, self._parent_velocity = self._position, self._velocity
        self._fitness: Array = np.full(len(self._position), np.inf)
        self._decay = DECAY_MAX
        self._unimproved = 0
        self._decay_step = REGULATING_SCALE * (DECAY_MAX - DECAY_MIN) / self._max_iterations  # (7)

    @property
    def stopped(self) -> str:
        """Reason why the run has ended, in words; empty as long as the run continues."""
        waited = self._patience is not None and self._unimproved >= self._patience
        return super().stopped or f"no improvement in {self._patience} iterations" * waited

    def _move(self) -> None:
        self._parent_position, self._parent_velocity = self._position, self._velocity
        super()._move()

    def _take(self, fitness: Array) -> None:
        if not self._history:
            super()._take(fitness)
            self._fitness = fitness
            return
        parent_personal, parent_best = self._personal.copy(), self._personal_fitness.copy()
        super()._take(fitness)
        error = np.concatenate((self._fitness, fitness))
        position = np.concatenate((self._parent_position, self._position))
        keep = survivors(
            error, position / (self._high - self._low), self._decay, far_first=self._far_first
        )
        self._position, self._fitness = position.take(keep, axis=0), error[keep]
        self._velocity = _kept(self._parent_velocity, self._velocity, keep)
        self._personal = _kept(parent_personal, self._personal, keep)
        self._personal_fitness = _kept(parent_best, self._personal_fitness, keep)
        self._cool(improved=float(self._personal_fitness.min()) < self._history[-1])

    def _cool(self, *, improved: bool) -> None:
        """Eq. (8) and (9) as printed: the scale falls only when the best error stays."""
        self._unimproved = 0 if improved else self._unimproved + 1
        lower = self._decay - self._decay_step
        if lower < DECAY_MIN:
            self._decay = DECAY_MIN
        elif not improved:
            self._decay = lower


def survivors(error: Array, position: Array, decay: float, *, far_first: bool) -> NDArray[np.intp]:
    """Returns the indices of the half that survives, the best score first: eq. (5), (6).

    Errors have the shape (2n,) and are infinite where discarded, positions (2n, d) are in units of
    the box, and `decay` is the weight rho of the distance rank.
    """
    best = int(error.argmin())
    away = position - position[best]
    squared = np.einsum("ij,ij->i", away, away)  # the root gives the same ranks
    score = _ranks(error) + decay * _ranks(-squared if far_first else squared)
    keep = score.argsort(kind="stable")[: error.size // 2]
    if best not in keep:
        keep[-1] = best
    return keep


def _ranks(values: Array) -> Array:
    ranks = np.empty(values.size)
    ranks[values.argsort(kind="stable")] = np.arange(1, values.size + 1)
    return ranks


def _kept(parents: Array, offspring: Array, keep: NDArray[np.intp]) -> Array:
    return np.concatenate((parents, offspring)).take(keep, axis=0)


CORES: dict[str, type[Swarm]] = {
    "pso": PSO,
    "sa-pso": SAPSO,
    "mpso": MPSO,
    "rank-distance-mpso": RankDistanceMPSO,
}


def minimized(
    core: type[Swarm],
    objective: Objective,
    bounds: Bounds,
    *,
    callback: Callback | None = None,
    **options: Any,
) -> OptimizeResult:
    """Minimizes with a swarm; `pso`, `sa_pso`, `mpso` and `rank_distance_mpso` are this function.

    Args:
        core: Class of the swarm.
        objective: Function that maps positions (n, d) to values (n,); a value that is not finite
            discards that position.
        bounds: One pair (low, high) per parameter; a particle beyond is set back to the bound and
            keeps its velocity.
        callback: Function that gets the intermediate result after every iteration; it may raise
            StopIteration.
        **options: Options of the swarm.

    Returns:
        A result with `x`, `fun`, `nit`, `nfev`, `history` (best value before the first and after
        each iteration), `discarded`, `population`, `success`, `message`.
    """
    return core(bounds, **options).minimize(objective, callback)


pso = partial(minimized, PSO)
"""Minimizes by the basic particle swarm, with the arguments of `minimized` and of `PSO`."""
sa_pso = partial(minimized, SAPSO)
"""Minimizes by SA-PSO of Li et al. 2022, with the arguments of `minimized` and of `SAPSO`."""
mpso = partial(minimized, MPSO)
"""Minimizes by MPSO of Li et al. 2022, with the arguments of `minimized` and of `MPSO`."""
rank_distance_mpso = partial(minimized, RankDistanceMPSO)
"""Minimizes by the MPSO of Kao and Fung 2009, with the arguments of `RankDistanceMPSO`, too."""
SWARMS: dict[str, Optimizer] = {name: partial(minimized, core) for name, core in CORES.items()}
OPTIMIZERS: dict[str, Optimizer] = dict(SWARMS)


def options_of(name: str) -> list[str]:
    """Returns the names of the options of an optimizer."""
    made = CORES[name].__mro__ if name in CORES else [OPTIMIZERS[name]]
    signatures = [inspect.signature(one).parameters for one in made if one not in (ABC, object)]
    every = [one for parameters in signatures for one in parameters.values()]
    return list(dict.fromkeys(one.name for one in every if one.kind is not one.VAR_KEYWORD))


def register_optimizer(name: str, minimize: Optimizer) -> None:
    """Makes an optimizer known to `identify`, as a method of `Search` and of the command line.

    `identify` calls `minimize(objective, bounds, rng=generator, **options)`. The objective maps
    positions (n, d) to values (n,), infinite outside its domain, and bounds are d pairs. The
    options are the further arguments of `minimize`. Trials run in parallel threads: `minimize` must
    not keep anything between calls.

    Args:
        name: Name of the method.
        minimize: Function whose result has `x`, `fun` and `history`, as that of `pso`.
    """
    if not callable(minimize):
        raise InputError(f"optimizer {name!r} is {minimize!r}: give a function that minimizes")
    if name in NO_SEARCHES or OPTIMIZERS.setdefault(name, minimize) is not minimize:
        raise InputError(f"there is another method {name!r}: choose another name")
