"""The speed of the certified fit against a published swarm, and of swarms beside libraries."""

import contextlib
import importlib.util
import statistics
import tempfile
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from ..assets import curves_path
from ..identification import Curve, CurveObjective, Search, certified_fit, fit_curves, load_curves
from ..identification.swarms.variants import SWARMS, pso, sa_pso
from ..published import LI_BOUNDS
from ..scripts.output import messages
from .hysteresis import textbook_rk4
from .timing import Row, Work, compare, seconds

DIMENSIONS, POPULATION, ITERATIONS = 5, 50, 100
BOUNDS = [(-5.12, 5.12)] * DIMENSIONS
EVALUATIONS = POPULATION * (ITERATIONS + 1)
OVERHEAD_LIMIT = 1.0  # us per evaluation


def rows(repeats: int) -> list[Row]:
    """Times the identification of the elbow, and the optimizers' own work.

    Args:
        repeats: Number of pairs of measurements of each row.
    """
    curves = load_curves(curves_path("elbow")).fitted()
    return [
        compare(
            "certified fit, elbow",
            lambda: certified_fit(curves, rng=0),
            "one SA-PSO trial",
            lambda: fit_curves(curves, method=Search("sa-pso", trials=1), workers=1),
            repeats=repeats,
            unit="ms",
        ),
        compare(
            "one SA-PSO trial of Li et al. 2022, elbow",
            lambda: sa_pso(CurveObjective(curves, loss="paper"), LI_BOUNDS, rng=0),
            "with the usual RK4 loop",
            lambda: sa_pso(_by_rk4(curves), LI_BOUNDS, rng=0),
            repeats=min(repeats, 3),
            unit="ms",
            target=8.0,
        ),
        *swarm_rows(repeats),
    ]


def _by_rk4(curves: list[Curve]) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """Returns eq. (7) of Li et al. 2022 for a population, with one RK4 step in H per sample."""
    angles = [np.degrees(curve.angle) for curve in curves]
    measured = np.concatenate([curve.torque for curve in curves])
    work = [np.empty_like(angle) for angle in angles]

    def objective(parameters: NDArray[np.float64]) -> NDArray[np.float64]:
        scores = np.empty(len(parameters))
        for row, values in enumerate(parameters):
            for angle, torque in zip(angles, work, strict=True):
                textbook_rk4(angle, *values, torque)
            error = (np.concatenate(work) - measured) / np.abs(measured).max()
            scores[row] = np.sqrt(np.sum(error**2)) / measured.size
        return scores

    return objective


def swarm_rows(repeats: int) -> list[Row]:
    """Times the work that each optimizer adds to its objective: 5-D Rastrigin, population 50."""
    found = [
        Row(
            what=f"{name}: overhead beyond the objective",
            unit="us/evaluation",
            ours=statistics.median(_overheads(repeats, _ours(swarm))[0]),
            limit=OVERHEAD_LIMIT,
        )
        for name, swarm in SWARMS.items()
    ]
    for name, package, other in (
        ("pyswarms PSO", "pyswarms", _pyswarms),
        ("SciPy differential evolution", "scipy", _scipy),
        ("pymoo PSO", "pymoo", _pymoo),
        ("pycma", "cma", _cma),
    ):
        if importlib.util.find_spec(package) is None:
            messages.print(f"{name} is left out: the package {package} is not installed")
            continue
        with other() as run:
            ours, reference = _overheads(repeats, _ours(pso), run)
        ratios = [b / a for a, b in zip(ours, reference, strict=True)]
        found.append(
            Row(
                what="pso: overhead beyond the objective",
                against=name,
                unit="us/evaluation",
                ours=statistics.median(ours),
                reference=statistics.median(reference),
                ratio=statistics.median(ratios),
                lowest=min(ratios),
                highest=max(ratios),
            )
        )
    return found


def rastrigin(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns Rastrigin's function at positions (n, d), shape (n,)."""
    return 10 * x.shape[1] + np.sum(x * x - 10 * np.cos(2 * np.pi * x), axis=1)


def _overheads(repeats: int, *works: Work) -> list[list[float]]:
    """Returns the microseconds per evaluation of each work, without those of the objective."""
    points = np.random.default_rng(0).uniform(-5.12, 5.12, (POPULATION, DIMENSIONS))

    def objective() -> None:
        for _ in range(ITERATIONS + 1):
            rastrigin(points)

    for work in works:
        work()
    found: list[list[float]] = [[] for _ in works]
    for _ in range(repeats):
        base = seconds(objective)
        for work, times in zip(works, found, strict=True):
            times.append((seconds(work) - base) / EVALUATIONS * 1e6)
    return found


def _ours(swarm: Callable[..., Any]) -> Work:
    return lambda: swarm(rastrigin, BOUNDS, swarm_size=POPULATION, max_iterations=ITERATIONS, rng=0)


@contextlib.contextmanager
def _pyswarms() -> Iterator[Work]:
    # It opens a log file in the current folder.
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        single = importlib.import_module("pyswarms.single")
        low, high = np.array(BOUNDS).T

        def run() -> None:
            swarm = single.GlobalBestPSO(
                n_particles=POPULATION,
                dimensions=DIMENSIONS,
                options={"c1": 2.0, "c2": 2.0, "w": 0.7},
                bounds=(low, high),
            )
            swarm.optimize(rastrigin, iters=ITERATIONS + 1, verbose=False)

        yield run


@contextlib.contextmanager
def _scipy() -> Iterator[Work]:
    yield lambda: optimize.differential_evolution(
        lambda columns: rastrigin(columns.T),
        BOUNDS,
        maxiter=ITERATIONS,
        popsize=POPULATION // DIMENSIONS,
        tol=0.0,
        polish=False,
        init="random",
        vectorized=True,
        updating="deferred",
        rng=0,
    )


@contextlib.contextmanager
def _pymoo() -> Iterator[Work]:
    problems = importlib.import_module("pymoo.core.problem")
    algorithms = importlib.import_module("pymoo.algorithms.soo.nonconvex.pso")
    runner = importlib.import_module("pymoo.optimize")

    class Rastrigin(problems.Problem):
        def _evaluate(self, x: Any, out: dict[str, Any], *_: Any, **__: Any) -> None:
            out["F"] = rastrigin(x)[:, np.newaxis]

    problem = Rastrigin(n_var=DIMENSIONS, n_obj=1, xl=-5.12, xu=5.12)
    yield lambda: runner.minimize(
        problem, algorithms.PSO(pop_size=POPULATION), ("n_gen", ITERATIONS + 1), seed=0
    )


@contextlib.contextmanager
def _cma() -> Iterator[Work]:
    cma = importlib.import_module("cma")
    options = {"bounds": [-5.12, 5.12], "popsize": POPULATION, "verbose": -9, "seed": 1}

    def run() -> None:
        strategy = cma.CMAEvolutionStrategy(np.ones(DIMENSIONS), 2.5, options)
        for _ in range(ITERATIONS + 1):
            asked = strategy.ask()
            strategy.tell(asked, rastrigin(np.array(asked)).tolist())

    yield run
