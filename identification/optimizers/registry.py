"""The optimizers by name: the papers' swarms, and those of other libraries."""

from collections.abc import Callable

from scipy.optimize import OptimizeResult

from .libraries import (
    cma_es,
    differential_evolution,
    dual_annealing,
    genetic_algorithm,
    nelder_mead,
)
from .mpso import mpso
from .pso import pso
from .rank_distance_mpso import rank_distance_mpso
from .sa_pso import sa_pso

Optimizer = Callable[..., OptimizeResult]

SWARMS: dict[str, Optimizer] = {
    "pso": pso,
    "sa-pso": sa_pso,
    "mpso": mpso,
    "rank-distance-mpso": rank_distance_mpso,
}
LIBRARIES: dict[str, Optimizer] = {
    "de": differential_evolution,
    "dual-annealing": dual_annealing,
    "nelder-mead": nelder_mead,
    "ga": genetic_algorithm,
    "cma-es": cma_es,
}
OPTIMIZERS: dict[str, Optimizer] = {**SWARMS, **LIBRARIES}
