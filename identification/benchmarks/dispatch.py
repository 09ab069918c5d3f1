"""The cost benchmark of Kao and Fung (2009), section 4.3: three units with valve points at 850 MW.

The paper names a modified IEEE 30-bus system with ten units and 24 hours, whose data it does not
print and which no public case matches. Its printed costs are those of the three-unit problem of
Walters and Sheble (1993): `relax_slack_bound=True` has its best cost, 8233.6607, as the minimum,
and 8250.2047, the worst cost of its Table 1, is a local minimum. The published number is therefore
the cost of a point that breaks the upper limit of unit 2 by 0.8 MW; the optimum within the limits
is 8234.0717.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError, unknown_name
from ...published import (
    KAO_COST_ITERATIONS,
    KAO_COST_SWARM,
    WALTERS_A,
    WALTERS_B,
    WALTERS_C,
    WALTERS_DEMAND,
    WALTERS_E,
    WALTERS_F,
    WALTERS_HIGHEST,
    WALTERS_LOWEST,
)
from ..optimizers.pso import KAO_FUNG
from ..optimizers.registry import KAO_FUNG_SWARMS

LOWEST, HIGHEST = np.array(WALTERS_LOWEST), np.array(WALTERS_HIGHEST)
A, B, C = map(np.array, (WALTERS_A, WALTERS_B, WALTERS_C))
E, F = np.array(WALTERS_E), np.array(WALTERS_F)

SLACK = 1  # the unit that closes the balance
FREE = (0, 2)
BOUNDS = tuple((float(LOWEST[i]), float(HIGHEST[i])) for i in FREE)
OPTIMUM = 8234.071730  # least cost of all dispatches within the limits [$/h]
RELAXED_OPTIMUM = 8233.660724  # least cost without limits of unit 2 [$/h]
REACHED = 0.01  # distance [$/h] within which a cost has reached the optimum, or the end of its run


def fuel_cost(output: ArrayLike) -> Array:
    """Returns the cost of dispatches whatever their limits and balance, (n, 3) [MW] -> (n,) [$/h].

    Walters and Sheble (1993): the sum of a + b P + c P^2 + |e sin(f (P_min - P))| over the units.

    Raises:
        InputError: `output` does not have three columns.
    """
    P = _rows(output, 3, "the outputs of units 1, 2 and 3")
    return np.sum(A + B * P + C * P**2 + np.abs(E * np.sin(F * (LOWEST - P))), axis=1)


def outputs(free: ArrayLike, *, relax_slack_bound: bool = False) -> Array:
    """Returns the outputs of all units that meet the demand, (n, 2) -> (n, 3) [MW].

    Unit 2 is the slack: it makes what units 1 and 3 leave. Where that is beyond its limits it stays
    at the limit, and unit 1, then unit 3, make up for it, so that every row is a dispatch within
    all limits and no penalty is needed, as the paper has it.

    Args:
        free: Outputs of units 1 and 3, within their limits [MW].
        relax_slack_bound: Whether unit 2 takes whatever is left, which the printed best cost needs.

    Raises:
        InputError: `free` does not have two columns.
    """
    given = _rows(free, 2, "the outputs of units 1 and 3")
    P = np.empty((len(given), 3))
    P[:, FREE] = given
    P[:, SLACK] = WALTERS_DEMAND - given.sum(axis=1)
    if relax_slack_bound:
        return P
    for unit in (SLACK, *FREE):
        others = P.sum(axis=1) - P[:, unit]
        P[:, unit] = np.clip(WALTERS_DEMAND - others, LOWEST[unit], HIGHEST[unit])
    return P


def dispatch_cost(free: ArrayLike, *, relax_slack_bound: bool = False) -> Array:
    """Returns the cost to minimize within `BOUNDS`, (n, 2) [MW] -> (n,) [$/h].

    Arguments and errors are those of `outputs`.
    """
    return fuel_cost(outputs(free, relax_slack_bound=relax_slack_bound))


def valve_points(unit: int) -> Array:
    """Returns where the cost of unit 0, 1 or 2 has its kinks, with both limits, rising [MW]."""
    spacing = np.pi / F[unit]
    inner = np.arange(LOWEST[unit], HIGHEST[unit], spacing)
    return np.append(inner, HIGHEST[unit])


@dataclass(frozen=True)
class CostTrial:
    """One run of a swarm on `dispatch_cost`.

    Attributes:
        cost: Best cost found [$/h].
        reached: Whether it is within `REACHED` of the optimum.
        converged: First iteration whose best cost is within `REACHED` of the run's last.
        seconds: Wall clock of the run.
        history: Best cost before the first and after each iteration [$/h].
    """

    cost: float
    reached: bool
    converged: int
    seconds: float
    history: Array


def cost_trials(
    method: str, *, trials: int = 100, relax_slack_bound: bool = False, seed: int = 0
) -> Iterator[CostTrial]:
    """Runs a swarm of 100 particles for 100 iterations, again and again, as section 4.3 does.

    Inertia falls linearly, eq. (4); the other constants, which section 4.3 leaves open, are those
    of section 4.4. Trial i of every method has the same random numbers to begin with.

    Args:
        method: "pso" or "rank-distance-mpso".
        trials: Number of runs.
        relax_slack_bound: Whether unit 2 takes whatever is left, as in `outputs`.
        seed: Seed of all trials.

    Yields:
        One result per trial.

    Raises:
        InputError: The method is unknown, or `trials` is below 1.
    """
    if method not in KAO_FUNG_SWARMS:
        raise unknown_name("method", method, KAO_FUNG_SWARMS)
    at_least("trials", trials, 1)
    optimum = RELAXED_OPTIMUM if relax_slack_bound else OPTIMUM
    options = {**KAO_FUNG, "inertia": "linear"}
    for trial in range(trials):
        start = time.perf_counter()
        found = KAO_FUNG_SWARMS[method](
            lambda free: dispatch_cost(free, relax_slack_bound=relax_slack_bound),
            BOUNDS,
            swarm_size=KAO_COST_SWARM,
            max_iterations=KAO_COST_ITERATIONS,
            rng=np.random.default_rng([seed, trial]),
            **options,
        )
        yield CostTrial(
            cost=float(found.fun),
            reached=bool(found.fun < optimum + REACHED),
            converged=int(np.argmax(found.history < found.fun + REACHED)),
            seconds=time.perf_counter() - start,
            history=found.history,
        )


def _rows(values: ArrayLike, columns: int, meaning: str) -> Array:
    rows = np.asarray(values, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise InputError(f"the dispatch has shape {rows.shape}: use (n, {columns}), {meaning}")
    return rows
