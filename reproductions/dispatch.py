"""The cost benchmark of Kao and Fung (2009), section 4.3: three units with valve points at 850 MW.

The paper names a modified IEEE 30-bus system with ten units and 24 hours, whose data it does not
print and which no public case matches. Its printed costs are those of the three-unit problem of
D. C. Walters and G. B. Sheble, "Genetic algorithm solution of economic dispatch with valve point
loading", IEEE Trans. Power Syst. 8 (1993): the printed best cost, 8233.6607, is the minimum where
unit 2 may break its limit, and 8250.2047, the printed worst cost of PSO, is a local minimum. The
optimum within the limits is 8234.0717.
"""

import time
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import Array
from ..identification import KAO_FUNG, pso, rank_distance_mpso

METHODS = {"pso": pso, "rank-distance-mpso": rank_distance_mpso}
SWARM, ITERATIONS = 100, 100  # particles and iterations of section 4.3

# Walters and Sheble (1993): the demand [MW], and per unit the lowest and highest output [MW] and
# the coefficients of the cost [$/h].
DEMAND = 850.0
LOWEST, HIGHEST = np.array([100.0, 100.0, 50.0]), np.array([600.0, 400.0, 200.0])
A, B, C = np.array([[561, 310, 78], [7.92, 7.85, 7.97], [0.001562, 0.00194, 0.00482]])
E, F = np.array([[300.0, 200.0, 150.0], [0.0315, 0.042, 0.063]])

SLACK = 1  # the unit that closes the balance
FREE = (0, 2)
BOUNDS = tuple((float(LOWEST[i]), float(HIGHEST[i])) for i in FREE)
OPTIMUM = 8234.071730  # least cost of all dispatches within the limits [$/h]
RELAXED_OPTIMUM = 8233.660724  # least cost without limits of unit 2 [$/h]
REACHED = 0.01  # distance [$/h] within which a cost has reached the optimum, or the end of its run


def fuel_cost(output: ArrayLike) -> Array:
    """Returns the cost of dispatches whatever their limits and balance, (n, 3) [MW] -> (n,) [$/h].

    Walters and Sheble (1993): the sum of a + b P + c P^2 + |e sin(f (P_min - P))| over the units.
    """
    P = np.asarray(output, dtype=np.float64)
    return np.sum(A + B * P + C * P**2 + np.abs(E * np.sin(F * (LOWEST - P))), axis=1)


def outputs(free: ArrayLike, *, relaxed: bool = False) -> Array:
    """Returns the outputs of all units that meet the demand, (n, 2) -> (n, 3) [MW].

    Unit 2 is the slack: it makes what units 1 and 3 leave. Where that is beyond its limits it stays
    at the limit, and unit 1, then unit 3, make up for it, so that every row is a dispatch within
    all limits and no penalty is needed, as the paper has it. If `relaxed`, unit 2 takes whatever is
    left, which the printed best cost needs.
    """
    given = np.asarray(free, dtype=np.float64)
    P = np.empty((len(given), 3))
    P[:, FREE] = given
    P[:, SLACK] = DEMAND - given.sum(axis=1)
    if relaxed:
        return P
    for unit in (SLACK, *FREE):
        others = P.sum(axis=1) - P[:, unit]
        P[:, unit] = np.clip(DEMAND - others, LOWEST[unit], HIGHEST[unit])
    return P


class CostTrial(NamedTuple):
    """One run of a swarm."""

    cost: float  # best cost found [$/h]
    missed: float  # 1 if it is not within `REACHED` of the optimum, else 0
    converged: float  # first iteration whose best cost is within `REACHED` of the run's last
    seconds: float  # wall clock of the run [s]
    history: Array  # best cost before the first and after each iteration [$/h]


def cost_trials(method: str, *, trials: int, relaxed: bool, seed: int) -> list[CostTrial]:
    """Runs one of `METHODS` again and again, as section 4.3 does.

    Inertia falls linearly, eq. (4); the other constants, which section 4.3 leaves open, are those
    of section 4.4. Trial i of every method has the same random numbers to begin with.
    """
    found, optimum = [], RELAXED_OPTIMUM if relaxed else OPTIMUM
    options = {**KAO_FUNG, "inertia": "linear"}
    sizes = {"swarm_size": SWARM, "max_iterations": ITERATIONS}
    for trial in range(trials):
        start, rng = time.perf_counter(), np.random.default_rng([seed, trial])
        run = METHODS[method](
            lambda free: fuel_cost(outputs(free, relaxed=relaxed)),
            BOUNDS,
            rng=rng,
            **sizes,
            **options,
        )
        seconds, missed = time.perf_counter() - start, run.fun >= optimum + REACHED
        converged = float(np.argmax(run.history < run.fun + REACHED))
        found.append(CostTrial(run.fun, float(missed), converged, seconds, run.history))
    return found
