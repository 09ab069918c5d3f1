"""SA-PSO: the swarm whose leader is drawn by simulated annealing (Li et al. 2022, section 4)."""

import math
from typing import ClassVar, Literal, Unpack

import numpy as np
from scipy.optimize import OptimizeResult

from ...arrays import Array
from ...errors import InputError
from .pso import LEARNING_FACTOR, tanh_inertia
from .swarm import Bounds, Callback, Objective, Swarm, SwarmOptions

COOLING = 0.95
Temperature = Literal["paper", "ln5"] | float
DIVISORS = {"paper": math.exp(-10), "ln5": math.log(5)}


class SAPSO(Swarm):
    """SA-PSO as an ask/tell core.

    Args:
        bounds: One pair (low, high) per parameter.
        temperature: First temperature, as `sa_pso` takes it.
        **common: Options that every swarm takes; `SwarmOptions` lists them.
    """

    _CHANGING: ClassVar[tuple[str, ...]] = (*Swarm._CHANGING, "_first_temperature")

    def __init__(
        self,
        bounds: Bounds,
        *,
        temperature: Temperature = "paper",
        **common: Unpack[SwarmOptions],
    ) -> None:
        super().__init__(bounds, **common)
        self._divisor = _divisor(temperature)
        self._first_temperature = 0.0
        self._options["temperature"] = temperature

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


def sa_pso(
    objective: Objective,
    bounds: Bounds,
    *,
    temperature: Temperature = "paper",
    callback: Callback | None = None,
    **common: Unpack[SwarmOptions],
) -> OptimizeResult:
    """Minimizes with SA-PSO: eq. (5), (6), (8)-(12) and steps 1-12 of Li et al. 2022.

    In each iteration one random number picks, by the roulette of eq. (12), the personal best that
    the whole swarm follows; the best point ever found is kept apart and returned. `SAPSO` is the
    same as an ask/tell core that can be saved and resumed.

    Args:
        objective: Function to minimize, as `pso` takes it.
        bounds: One pair (low, high) per parameter.
        temperature: First temperature, as the best fitness divided by a number: "paper" is eq. (11)
            as printed, F / e^-10, which is so hot that the roulette stays uniform for all 100
            iterations; "ln5" is F / ln 5, the textbook rule; a number divides by that number.
        callback: Function that gets the intermediate result, as `pso` calls it.
        **common: Options that every swarm takes; `SwarmOptions` lists them.

    Returns:
        The result, with the fields that `pso` lists.
    """
    return SAPSO(bounds, temperature=temperature, **common).minimize(objective, callback)


def selection_probability(fitness: Array, temperature: float) -> Array:
    """Returns eq. (12): each particle's chance to lead, (n,); at temperature 0 the best leads."""
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
