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
    limit = velocity_limit * (high - low)
    position = rng.random((swarm_size, low.size)) * (high - low) + low
    velocity = rng.random((swarm_size, low.size)) * 2 * limit - limit
    fitness = _scores(objective, position)
    if not np.isfinite(fitness).any():
        raise InputError(
            f"the objective has no finite value at any of the {swarm_size} first particles: check "
            "the bounds and the data"
        )
    personal, personal_fitness = position.copy(), fitness.copy()
    history = [float(fitness.min())]
    discarded = int(np.count_nonzero(~np.isfinite(fitness)))
    iteration = 0

    def snapshot() -> OptimizeResult:
        best = int(np.argmin(personal_fitness))
        return OptimizeResult(
            x=personal[best].copy(),
            fun=float(personal_fitness[best]),
            nit=iteration,
            nfev=swarm_size * (iteration + 1),
            history=np.array(history),
            discarded=discarded,
            population=position.copy(),
        )

    reached = target is not None and history[0] < target
    while iteration < max_iterations and not reached:
        inertia, cognitive, social = coefficients(iteration, max_iterations)
        followed = personal[leader(personal_fitness, iteration, rng)]
        r1, r2 = rng.random((2, swarm_size, 1))
        velocity = (
            inertia * velocity
            + cognitive * r1 * (personal - position)
            + social * r2 * (followed - position)
        )
        velocity = np.clip(velocity, -limit, limit)
        position = np.clip(position + velocity, low, high)
        fitness = _scores(objective, position)
        discarded += int(np.count_nonzero(~np.isfinite(fitness)))
        better = fitness < personal_fitness
        personal[better], personal_fitness[better] = position[better], fitness[better]
        iteration += 1
        history.append(float(personal_fitness.min()))
        reached = target is not None and history[-1] < target
        if callback is not None:
            try:
                callback(snapshot())
            except StopIteration:
                return OptimizeResult(snapshot(), success=False, message="stopped by the callback")
    message = f"reached the target {target:g}" if reached else "ran all iterations"
    return OptimizeResult(snapshot(), success=True, message=message)


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
