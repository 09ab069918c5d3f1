"""Optimizers of other libraries behind one call, with a budget of evaluations, for comparison.

Every function here has the signature

    minimize(objective, bounds, max_evaluations, rng=None) -> OptimizeResult

and never evaluates more than `max_evaluations` points: a batch that would is cut short. SciPy's
are always there; the genetic algorithm needs pymoo and CMA-ES needs cma, the extra `compare`.
Options are the libraries' own defaults unless stated.
"""

import importlib
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import optimize
from scipy.optimize import OptimizeResult

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError, install_line
from .swarm import Bounds, Objective, checked_bounds, finite_scores

POPULATION = 50  # individuals of the genetic algorithm: as many as particles of the swarms
SIMPLEX_EDGE = 0.1  # edge of the first simplex, relative to the box
SIMPLEX_CONVERGED = 1e-6  # size of the simplex, relative to the box
CMA_STEP = 0.25  # first step size, relative to the box, as pycma advises
# What a library gets instead of a value that is not finite: infinity breaks their arithmetic.
DISCARDED = 1e100

Seed = int | np.random.Generator | None


def differential_evolution(
    objective: Objective, bounds: Bounds, max_evaluations: int, rng: Seed = None
) -> OptimizeResult:
    """Minimizes with SciPy's differential evolution: vectorized, unpolished, until all is spent.

    Args:
        objective: Function that maps positions (n, d) to values (n,); values that are not finite
            are discarded.
        bounds: One pair (low, high) per parameter.
        max_evaluations: Number of points that may be evaluated.
        rng: Seed or generator; the same seed gives the same result bit for bit.

    Returns:
        `x`, `fun`, `nfev`, `history` (best value after each evaluation, (nfev,)), `discarded`,
        `success`, `message`.

    Raises:
        InputError: Bounds, budget or the objective's shape are wrong, or no value is finite.
    """

    def search(budget: _Budget) -> None:
        optimize.differential_evolution(
            lambda columns: budget(columns.T),
            [(0.0, 1.0)] * budget.dimensions,
            maxiter=max_evaluations,
            tol=0.0,
            polish=False,
            vectorized=True,
            updating="deferred",
            rng=budget.rng,
        )

    return _minimize(objective, bounds, max_evaluations, rng, search)


def dual_annealing(
    objective: Objective, bounds: Bounds, max_evaluations: int, rng: Seed = None
) -> OptimizeResult:
    """Minimizes with SciPy's dual annealing, its local search included.

    Arguments, result and errors are those of `differential_evolution`.
    """

    def search(budget: _Budget) -> None:
        optimize.dual_annealing(
            budget.one,
            [(0.0, 1.0)] * budget.dimensions,
            maxiter=max_evaluations,
            maxfun=10 * max_evaluations,  # the budget ends it before
            rng=budget.rng,
        )

    return _minimize(objective, bounds, max_evaluations, rng, search)


def nelder_mead(
    objective: Objective, bounds: Bounds, max_evaluations: int, rng: Seed = None
) -> OptimizeResult:
    """Minimizes with SciPy's downhill simplex, the "DSM" of Li et al. 2022, from many points.

    Starts are uniform in the box; when a simplex has shrunk to a millionth of the box, the next
    start follows. Arguments, result and errors are those of `differential_evolution`.
    """

    def search(budget: _Budget) -> None:
        while True:  # the spent budget ends it
            start = budget.rng.random(budget.dimensions)
            edges = np.diag(np.where(start < 0.5, SIMPLEX_EDGE, -SIMPLEX_EDGE))
            optimize.minimize(
                budget.one,
                start,
                method="Nelder-Mead",
                bounds=[(0.0, 1.0)] * budget.dimensions,
                options={
                    "initial_simplex": np.vstack((start, start + edges)),
                    "maxfev": max_evaluations,
                    "maxiter": max_evaluations,
                    "xatol": SIMPLEX_CONVERGED,
                    "fatol": np.inf,  # no tolerance, whatever the objective's unit
                },
            )

    return _minimize(objective, bounds, max_evaluations, rng, search)


def genetic_algorithm(
    objective: Objective, bounds: Bounds, max_evaluations: int, rng: Seed = None
) -> OptimizeResult:
    """Minimizes with pymoo's genetic algorithm, population 50.

    Arguments, result and errors are those of `differential_evolution`.

    Raises:
        InputError: Also if pymoo is not installed.
    """
    problems = _library("pymoo.core.problem", "pymoo", "the genetic algorithm")
    algorithms = _library("pymoo.algorithms.soo.nonconvex.ga", "pymoo", "the genetic algorithm")
    runner = _library("pymoo.optimize", "pymoo", "the genetic algorithm")

    def search(budget: _Budget) -> None:
        class Box(problems.Problem):
            def _evaluate(self, x: Array, out: dict[str, Array], *_: Any, **__: Any) -> None:
                out["F"] = budget(x)[:, np.newaxis]

        runner.minimize(
            Box(n_var=budget.dimensions, n_obj=1, xl=0.0, xu=1.0),
            algorithms.GA(pop_size=POPULATION),
            ("n_eval", 2 * max_evaluations + POPULATION),  # the budget ends it before
            seed=int(budget.rng.integers(2**31)),
        )

    return _minimize(objective, bounds, max_evaluations, rng, search)


def cma_es(
    objective: Objective, bounds: Bounds, max_evaluations: int, rng: Seed = None
) -> OptimizeResult:
    """Minimizes with pycma's CMA-ES; each restart has twice the population of the one before.

    Starts are uniform in the box, the first step size is a quarter of it. Arguments, result and
    errors are those of `differential_evolution`.

    Raises:
        InputError: Also if cma is not installed, or there is only one parameter, which pycma
            does not take.
    """
    cma = _library("cma", "cma", "CMA-ES")

    def search(budget: _Budget) -> None:
        if budget.dimensions < 2:
            raise InputError("CMA-ES has 1 parameter to find: use at least 2, or another method")
        options = {
            "bounds": [0.0, 1.0],
            "verbose": -9,
            "randn": lambda *shape: budget.rng.standard_normal(shape),
            "seed": np.nan,  # NaN leaves NumPy's global generator alone
        }
        while True:  # the spent budget ends it
            start = budget.rng.random(budget.dimensions)
            strategy = cma.CMAEvolutionStrategy(start, CMA_STEP, options)
            while not strategy.stop():
                asked = strategy.ask()
                strategy.tell(asked, budget(np.array(asked)).tolist())
            options["popsize"] = 2 * strategy.popsize

    return _minimize(objective, bounds, max_evaluations, rng, search)


class _Ended(Exception):
    """Leaves a library's loop: the budget is spent, or the objective raised `error`."""

    def __init__(self, error: Exception | None = None) -> None:
        self.error = error


class _Budget:
    """The objective on the unit box, which counts and remembers, and ends when all is spent."""

    def __init__(self, objective: Objective, bounds: Bounds, allowed: int, rng: Seed) -> None:
        self._objective, self._allowed = objective, allowed
        self._low, self._high = checked_bounds(bounds)
        self.dimensions = self._low.size
        self.rng = np.random.default_rng(rng)
        self.best, self.best_position = np.inf, self._low
        self._values: list[Array] = []
        self.spent = 0

    def __call__(self, unit: Array) -> Array:
        """Returns the values, (n,), of points (n, d) of the unit box."""
        if self.spent == self._allowed:
            raise _Ended
        affordable = np.clip(unit[: self._allowed - self.spent], 0, 1)
        position = self._low + affordable * (self._high - self._low)
        position = np.minimum(position, self._high)  # the sum rounds
        try:
            values = finite_scores(self._objective(position.copy()), position.shape)
        except Exception as error:  # libraries replace some exceptions by their own
            raise _Ended(error) from error
        self._remember(position, values)
        if len(position) < len(unit):
            raise _Ended
        return np.where(values < np.inf, values, DISCARDED)

    def one(self, unit: Array) -> float:
        """Returns the value of one point (d,)."""
        return float(self(unit[np.newaxis])[0])

    def _remember(self, position: Array, values: Array) -> None:
        self._values.append(values)
        self.spent += len(values)
        best = int(values.argmin())
        if values[best] < self.best:
            self.best, self.best_position = float(values[best]), position[best]

    def result(self, message: str) -> OptimizeResult:
        values = np.concatenate(self._values)
        if self.best == np.inf:
            raise InputError(
                f"the objective has no finite value at any of {self.spent} points: check the "
                "bounds and the data"
            )
        return OptimizeResult(
            x=self.best_position,
            fun=self.best,
            nfev=self.spent,
            history=np.minimum.accumulate(values),
            discarded=int(np.count_nonzero(values == np.inf)),
            success=True,
            message=message,
        )


def _minimize(
    objective: Objective,
    bounds: Bounds,
    max_evaluations: int,
    rng: Seed,
    search: Callable[[_Budget], None],
) -> OptimizeResult:
    at_least("max_evaluations", max_evaluations, 1)
    budget = _Budget(objective, bounds, max_evaluations, rng)
    try:
        search(budget)
    except _Ended as end:
        if end.error is not None:
            raise end.error from None
        return budget.result("spent all evaluations")
    return budget.result("converged before all evaluations were spent")


def _library(module: str, package: str, method: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"{method} needs the package {package}, which is not installed: run "
            f"{install_line('compare')} in the clone of the repository"
        ) from error
