"""Which optimizer identifies a joint with the fewest model runs?

The swarms of Li et al. (2022), optimizers of SciPy, pymoo and pycma, and the certified fit identify
the shipped elbow curves from twenty seeds, with the 5050 model runs of the paper. A method whose
package is not installed is left out.

The error is the NRMSE over that of the parameters that made the curves: 1.00 is as good as the
truth. A trial has *arrived* if it is within 5 % of that. The certified fit, least squares from a
few starts, arrives from every seed with fifty times fewer model runs. No swarm and no genetic
algorithm arrives within the budget.

`register_optimizer` makes a function of the objective, the bounds and a generator a method of
`identify`, as `Search("de", trials=10)`; from the module of a package that is named in the entry
point group `activesuit` also a choice of `activesuit identify --method`.

Sources: Storn and Price 1997 (differential evolution); Xiang et al. 2013 (dual annealing); Nelder
and Mead 1965; Blank and Deb 2020 (pymoo); Hansen 2016 (CMA-ES).
"""

from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec
from typing import Any

import numpy as np
import tyro
from activesuit.assets import curves_path
from activesuit.hysteresis import TABLE_2
from activesuit.identification import (
    Certified,
    CurveObjective,
    Fit,
    Search,
    fit_curves,
    load_curves,
    register_optimizer,
)
from matplotlib.figure import Figure
from scipy import optimize

SWARMS = ("pso", "sa-pso", "mpso")
SWARM_SIZE = 50
RUNS = SWARM_SIZE * 101  # of the model, by a swarm of the paper: 100 iterations after the first
ARRIVED = 1.05  # error over that of the noise
WORST = 1e100  # what a library gets instead of infinity, which breaks its arithmetic
CMA_STEP, SIMPLEX = 0.25, 0.1  # first step and edge of the first simplex, over the box


class Spent(Exception):
    """All model runs are used up."""


class Budget:
    """An objective on the unit box, which ends any optimizer after a number of model runs."""

    def __init__(self, objective: Callable[..., Any], bounds: Any, runs: int) -> None:
        self.objective, self.left = objective, runs
        self.low, self.high = np.array(bounds, dtype=float).T
        self.points: list[Any] = []
        self.values: list[Any] = []

    def __call__(self, unit: Any) -> Any:
        """Returns the values, (n,), of points of the box, (n, d)."""
        if not self.left:
            raise Spent
        points = self.low + np.clip(unit[: self.left], 0, 1) * (self.high - self.low)
        values = self.objective(points)
        self.left -= len(points)
        self.points.append(points)
        self.values.append(values)
        if len(points) < len(unit):
            raise Spent
        return np.minimum(values, WORST)

    def one(self, unit: Any) -> float:
        """Returns the value of one point, (d,)."""
        return float(self(unit[None])[0])


def within_budget(search: Callable[[Budget, int, np.random.Generator], None]) -> Any:
    """Returns a search of a unit box as `register_optimizer` takes it."""

    def minimize(objective: Any, bounds: Any, rng: np.random.Generator, runs: int = RUNS) -> Any:
        budget = Budget(objective, bounds, runs)
        with suppress(Spent):
            while True:  # what converges before, begins again
                search(budget, len(bounds), rng)
        points, values = np.concatenate(budget.points), np.concatenate(budget.values)
        best, history = int(np.argmin(values)), np.minimum.accumulate(values)
        return optimize.OptimizeResult(x=points[best], fun=values[best], history=history)

    return minimize


def differential_evolution(budget: Budget, size: int, rng: np.random.Generator) -> None:
    optimize.differential_evolution(
        lambda columns: budget(columns.T),
        [(0, 1)] * size,
        maxiter=RUNS,
        tol=0,
        polish=False,
        vectorized=True,
        updating="deferred",
        rng=rng,
    )


def dual_annealing(budget: Budget, size: int, rng: np.random.Generator) -> None:
    optimize.dual_annealing(budget.one, [(0, 1)] * size, maxiter=RUNS, maxfun=10 * RUNS, rng=rng)


def nelder_mead(budget: Budget, size: int, rng: np.random.Generator) -> None:
    start = rng.random(size)
    simplex = np.vstack([start, start + np.diag(np.where(start < 0.5, SIMPLEX, -SIMPLEX))])
    options = {"initial_simplex": simplex, "maxiter": RUNS, "maxfev": RUNS, "xatol": 1e-6}
    options["fatol"] = np.inf  # the size of the simplex alone ends it
    optimize.minimize(
        budget.one, start, method="Nelder-Mead", bounds=[(0, 1)] * size, options=options
    )


def genetic_algorithm(budget: Budget, size: int, rng: np.random.Generator) -> None:
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    class Box(Problem):
        def _evaluate(self, x: Any, out: dict[str, Any], *_: Any, **__: Any) -> None:
            out["F"] = budget(x)[:, None]

    box = Box(n_var=size, n_obj=1, xl=0.0, xu=1.0)
    minimize(box, GA(pop_size=SWARM_SIZE), ("n_eval", 2 * RUNS), seed=int(rng.integers(2**31)))


def cma_es(budget: Budget, size: int, rng: np.random.Generator) -> None:
    import cma

    options: dict[str, Any] = {"bounds": [0, 1], "verbose": -9, "seed": np.nan}
    options["randn"] = lambda *shape: rng.standard_normal(shape)
    while True:  # each restart has twice the population of the one before
        strategy = cma.CMAEvolutionStrategy(rng.random(size), CMA_STEP, options)
        while not strategy.stop():
            asked = strategy.ask()
            strategy.tell(asked, budget(np.array(asked)))
        options["popsize"] = 2 * strategy.popsize


def registered() -> list[str]:
    """Registers the optimizers whose packages are installed, and returns their names."""
    found = {
        "de": differential_evolution,
        "dual-annealing": dual_annealing,
        "nelder-mead": nelder_mead,
        **({"ga": genetic_algorithm} if find_spec("pymoo") else {}),
        **({"cma-es": cma_es} if find_spec("cma") else {}),
    }
    for name, search in found.items():
        register_optimizer(name, within_budget(search))
    return list(found)


def report(fits: dict[str, Fit], floor: float) -> None:
    print("error over that of the noise (1.00), over the trials; model runs of a trial")
    print(f"{'method':<16}{'median':>8}{'lowest':>8}{'highest':>9}{'arrived':>10}{'runs':>8}")
    for name, fit in fits.items():
        errors = np.array([one.nrmse for one in fit.trials]) / floor
        arrived = f"{np.count_nonzero(errors <= ARRIVED)} of {len(errors)}"
        runs = np.median([one.evaluations or 0 for one in fit.trials])
        numbers = f"{np.median(errors):>8.2f}{errors.min():>8.2f}{errors.max():>9.2f}"
        print(f"{name:<16}{numbers}{arrived:>10}{runs:>8.0f}")


def draw(fits: dict[str, Fit], floor: float) -> Figure:
    figure = Figure(figsize=(8, 4.6), layout="constrained")
    axis = figure.add_subplot()
    for number, (name, fit) in enumerate(fits.items()):
        if name == "certified":
            spent = np.median([one.evaluations or 0 for one in fit.trials])
            error = np.median([one.nrmse for one in fit.trials]) / floor
            axis.plot(spent, error, "k*", ms=14, label=name)
            continue
        history = np.median([one.history for one in fit.trials], axis=0) / floor
        each = SWARM_SIZE if name in SWARMS else 1  # a swarm tells its best of each iteration
        spent = each * np.arange(1, len(history) + 1)
        axis.plot(spent, history, f"C{number}", ls="--" if name in SWARMS else "-", label=name)
    axis.axhline(1, color="0.7", lw=0.8, zorder=0)
    axis.set(xscale="log", yscale="log", xlabel="model runs", xlim=(20, RUNS), ylim=(0.9, 40))
    axis.set_ylabel("NRMSE / that of the noise, median")
    axis.set_yticks([1, 2, 5, 10, 20], ["1", "2", "5", "10", "20"])
    axis.spines[["top", "right"]].set_visible(False)
    figure.legend(loc="outside right center", frameon=False)
    return figure


def main(trials: int = 20, quick: bool = False) -> None:
    """Compare optimizers on the elbow curves.

    Args:
        trials: Number of seeds of each method.
        quick: Two seeds of each.
    """
    trials = 2 if quick else trials
    curves = load_curves(curves_path("elbow"))
    truth = TABLE_2["elbow-sa-pso"]
    row = [truth.Ms, truth.a, truth.alpha, truth.c, truth.k]
    floor = float(CurveObjective(curves.fitted()).nrmse(row)[0])
    methods = {"certified": Certified(trials=trials)}
    methods |= {name: Search(name, trials=trials) for name in (*SWARMS, *registered())}
    fits = {name: fit_curves(curves, method=method) for name, method in methods.items()}
    report(fits, floor)
    draw(fits, floor).savefig("optimizers.png", dpi=150)


if __name__ == "__main__":
    tyro.cli(main)
