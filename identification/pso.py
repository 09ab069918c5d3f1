"""The basic particle swarm of Li et al. 2022, section 4.1."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import OptimizeResult

from ._swarm import Callback, Objective, run_swarm

INERTIA_MAX, INERTIA_MIN = 0.95, 0.4
LEARNING_FACTOR = 2.0


def tanh_coefficients(iteration: int, iterations: int) -> tuple[float, float, float]:
    """Inertia falling along a tanh, eq. (10), from 0.95 to 0.4, and c1 = c2 = 2."""
    mean, half = (INERTIA_MAX + INERTIA_MIN) / 2, (INERTIA_MAX - INERTIA_MIN) / 2
    inertia = math.tanh(-5 + 10 * (iterations - iteration) / iterations) * half + mean
    return inertia, LEARNING_FACTOR, LEARNING_FACTOR


def pso(
    objective: Objective,
    bounds: Sequence[tuple[float, float]],
    *,
    swarm_size: int = 50,
    max_iterations: int = 100,
    velocity_limit: float = 0.2,
    target: float | None = None,
    rng: int | np.random.Generator | None = None,
    callback: Callback | None = None,
) -> OptimizeResult:
    """Minimizes with the basic swarm: eq. (5), (6), (8)-(10) of Li et al. 2022.

    Args:
        objective: maps positions (n, d) to values (n,); a value that is not finite discards that
            position.
        bounds: one pair (low, high) per parameter; a particle beyond is set back to the bound.
        swarm_size: number of particles.
        max_iterations: number of moves after the first evaluation.
        velocity_limit: largest move per iteration, as a fraction of each parameter's range. The
            paper leaves Vmax open.
        target: stop once the best value is below (the paper's steps 4 and 11 use 1e-3).
        rng: seed or generator; the same seed gives the same result bit for bit.
        callback: called with the intermediate result after every iteration; it may raise
            StopIteration.

    Returns:
        `x`, `fun`, `nit`, `nfev`, `history` (best value before the first and after each iteration),
        `discarded`, `population`, `success`, `message`.

    Raises:
        InputError: bounds, sizes or the objective's shape are wrong, or no first value is finite.
    """
    return run_swarm(
        objective,
        bounds,
        coefficients=tanh_coefficients,
        swarm_size=swarm_size,
        max_iterations=max_iterations,
        velocity_limit=velocity_limit,
        target=target,
        rng=rng,
        callback=callback,
    )
