"""The particle swarm that all variants share; a variant is its coefficients and its leader."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import OptimizeResult

from ..errors import InputError

Array = NDArray[np.float64]
Objective = Callable[[Array], ArrayLike]
Callback = Callable[[OptimizeResult], None]
# (iteration from 0, iterations) -> inertia, cognitive and social coefficient
Coefficients = Callable[[int, int], tuple[float, float, float]]
# (fitness of the personal bests, iteration from 0, generator) -> index of the particle to follow
Leader = Callable[[Array, int, np.random.Generator], int]


def best_particle(fitness: Array, iteration: int, rng: np.random.Generator) -> int:
    """Follows the best personal best, as the basic swarm does."""
    return int(np.argmin(fitness))


def run_swarm(
    objective: Objective,
    bounds: Sequence[tuple[float, float]],
    *,
    coefficients: Coefficients,
    leader: Leader = best_particle,
    swarm_size: int,
    max_iterations: int,
    velocity_limit: float,
    target: float | None,
    rng: int | np.random.Generator | None,
    callback: Callback | None,
) -> OptimizeResult:
    """Minimizes by eq. (5), (6), (8), (9) and steps 2-4, 9-12 of Li et al. 2022, section 4.3.

    A position or velocity that leaves its limits is set back to the limit. Values that are not
    finite count as infinitely bad. The result is the best point ever evaluated, whatever particle
    the swarm was following.
    """
    low, high = checked_bounds(bounds)
    if swarm_size < 2 or max_iterations < 1 or not 0 < velocity_limit <= 1:
        raise InputError(
            f"swarm_size is {swarm_size}, max_iterations {max_iterations}, velocity_limit "
            f"{velocity_limit}: use at least 2, at least 1, and a fraction in (0, 1]"
        )
    rng = np.random.default_rng(rng)
    swarm = _Swarm(objective, low, high, swarm_size, velocity_limit, rng)
    reached = target is not None and swarm.history[0] < target
    while swarm.iteration < max_iterations and not reached:
        followed = leader(swarm.personal_fitness, swarm.iteration, rng)
        swarm.move(coefficients(swarm.iteration, max_iterations), followed)
        reached = target is not None and swarm.history[-1] < target
        if callback is not None:
            try:
                callback(swarm.result())
            except StopIteration:
                return OptimizeResult(
                    swarm.result(), success=False, message="stopped by the callback"
                )
    message = f"reached the target {target:g}" if reached else "ran all iterations"
    return OptimizeResult(swarm.result(), success=True, message=message)


class _Swarm:
    """Particles with velocities and personal bests; scattered by eq. (5) and (6)."""

    def __init__(
        self,
        objective: Objective,
        low: Array,
        high: Array,
        size: int,
        velocity_limit: float,
        rng: np.random.Generator,
    ) -> None:
        self._objective, self._low, self._high, self._rng = objective, low, high, rng
        self._limit = limit = velocity_limit * (high - low)
        self._position = rng.random((size, low.size)) * (high - low) + low
        self._velocity = rng.random((size, low.size)) * 2 * limit - limit
        fitness = _scores(objective, self._position)
        if not np.isfinite(fitness).any():
            raise InputError(
                f"the objective has no finite value at any of the {size} first particles: check "
                "the bounds and the data"
            )
        self._personal, self.personal_fitness = self._position.copy(), fitness.copy()
        self.history = [float(fitness.min())]
        self._discarded = int(np.count_nonzero(~np.isfinite(fitness)))
        self.iteration = 0

    def move(self, coefficients: tuple[float, float, float], followed: int) -> None:
        """Moves every particle once, by eq. (8) and (9), with particle `followed` in the lead."""
        inertia, cognitive, social = coefficients
        r1, r2 = self._rng.random((2, len(self._position), 1))
        velocity = (
            inertia * self._velocity
            + cognitive * r1 * (self._personal - self._position)
            + social * r2 * (self._personal[followed] - self._position)
        )
        self._velocity = np.clip(velocity, -self._limit, self._limit)
        self._position = np.clip(self._position + self._velocity, self._low, self._high)
        fitness = _scores(self._objective, self._position)
        self._discarded += int(np.count_nonzero(~np.isfinite(fitness)))
        better = fitness < self.personal_fitness
        self._personal[better] = self._position[better]
        self.personal_fitness[better] = fitness[better]
        self.iteration += 1
        self.history.append(float(self.personal_fitness.min()))

    def result(self) -> OptimizeResult:
        """Returns what is known by now."""
        best = int(np.argmin(self.personal_fitness))
        return OptimizeResult(
            x=self._personal[best].copy(),
            fun=float(self.personal_fitness[best]),
            nit=self.iteration,
            nfev=len(self._position) * (self.iteration + 1),
            history=np.array(self.history),
            discarded=self._discarded,
            population=self._position.copy(),
        )


def checked_bounds(bounds: Sequence[tuple[float, float]]) -> tuple[Array, Array]:
    """Returns the lower and upper bounds, shape (d,) each.

    Raises:
        InputError: they are not d finite pairs (low, high) with low < high.
    """
    pairs = np.asarray(bounds, dtype=np.float64)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.size == 0:
        raise InputError(
            f"bounds have shape {pairs.shape}: give one pair (low, high) per parameter"
        )
    for index, (low, high) in enumerate(pairs):
        if not (np.isfinite(low) and np.isfinite(high) and low < high):
            raise InputError(
                f"bounds[{index}] are ({low:g}, {high:g}): give finite numbers with low < high"
            )
    return pairs[:, 0], pairs[:, 1]


def _scores(objective: Objective, position: Array) -> Array:
    fitness = np.asarray(objective(position), dtype=np.float64)
    if fitness.shape != (len(position),):
        raise InputError(
            f"the objective returned shape {fitness.shape} for {len(position)} particles: it must "
            f"map (n, d) to (n,), here ({len(position)},)"
        )
    return np.where(np.isfinite(fitness), fitness, np.inf)
