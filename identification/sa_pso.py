"""SA-PSO: the swarm whose leader is drawn by simulated annealing (Li et al. 2022, section 4)."""

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
from scipy.optimize import OptimizeResult

from ..errors import InputError
from ._swarm import Array, Callback, Leader, Objective, run_swarm
from .pso import tanh_coefficients

COOLING = 0.95
Temperature = Literal["paper", "ln5"] | float
DIVISORS = {"paper": math.exp(-10), "ln5": math.log(5)}


def sa_pso(
    objective: Objective,
    bounds: Sequence[tuple[float, float]],
    *,
    swarm_size: int = 50,
    max_iterations: int = 100,
    temperature: Temperature = "paper",
    velocity_limit: float = 0.2,
    target: float | None = None,
    rng: int | np.random.Generator | None = None,
    callback: Callback | None = None,
) -> OptimizeResult:
    """Minimizes with SA-PSO: eq. (5), (6), (8)-(12) and steps 1-12 of Li et al. 2022.

    In each iteration one random number picks, by the roulette of eq. (12), the personal best that
    the whole swarm follows; the best point ever found is kept apart and returned.

    Args:
        objective: see `pso`.
        bounds: see `pso`.
        swarm_size: see `pso`.
        max_iterations: see `pso`.
        temperature: the first temperature, as the best fitness divided by a number: "paper" is
            eq. (11) as printed, F / e^-10, which is so hot that the roulette stays uniform for all
            100 iterations; "ln5" is F / ln 5, the textbook rule; a number divides by that number.
        velocity_limit: see `pso`.
        target: see `pso`.
        rng: see `pso`.
        callback: see `pso`.

    Returns:
        See `pso`.

    Raises:
        InputError: see `pso`; or `temperature` is none of the above.
    """
    return run_swarm(
        objective,
        bounds,
        coefficients=tanh_coefficients,
        leader=annealed_leader(temperature),
        swarm_size=swarm_size,
        max_iterations=max_iterations,
        velocity_limit=velocity_limit,
        target=target,
        rng=rng,
        callback=callback,
    )


def annealed_leader(temperature: Temperature) -> Leader:
    """Returns the roulette of eq. (11) and (12), which cools by 0.95 in every iteration."""
    divisor = (
        DIVISORS.get(temperature, temperature) if isinstance(temperature, str) else temperature
    )
    if isinstance(divisor, str) or not (math.isfinite(divisor) and divisor > 0):
        raise InputError(f"temperature is {temperature!r}: use 'paper', 'ln5' or a divisor above 0")
    first = 0.0

    def follow(fitness: Array, iteration: int, rng: np.random.Generator) -> int:
        nonlocal first
        if iteration == 0:
            first = float(fitness.min()) / divisor
        share = selection_probability(fitness, first * COOLING**iteration)
        return min(int(np.searchsorted(np.cumsum(share), rng.random())), fitness.size - 1)

    return follow


def selection_probability(fitness: Array, temperature: float) -> Array:
    """Returns eq. (12): each particle's chance to lead, (n,); at temperature 0 the best leads."""
    if temperature <= 0:
        return (np.arange(fitness.size) == np.argmin(fitness)).astype(np.float64)
    weight = np.exp(-(fitness - fitness.min()) / temperature)
    return weight / weight.sum()
