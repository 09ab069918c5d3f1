"""Optimizers of any function of a few bounded parameters: the published swarms, and libraries'."""

from .libraries import (
    cma_es,
    differential_evolution,
    dual_annealing,
    genetic_algorithm,
    nelder_mead,
)
from .mpso import MPSO, mpso
from .pso import KAO_FUNG, PSO, pso
from .rank_distance_mpso import RankDistanceMPSO, rank_distance_mpso
from .sa_pso import SAPSO, sa_pso

__all__ = [
    "KAO_FUNG",
    "MPSO",
    "PSO",
    "SAPSO",
    "RankDistanceMPSO",
    "cma_es",
    "differential_evolution",
    "dual_annealing",
    "genetic_algorithm",
    "mpso",
    "nelder_mead",
    "pso",
    "rank_distance_mpso",
    "sa_pso",
]
