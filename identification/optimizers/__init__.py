"""Optimizers of any function of a few bounded parameters: the published swarms."""

from .mpso import MPSO, mpso
from .pso import KAO_FUNG, PSO, pso
from .rank_distance_mpso import RankDistanceMPSO, rank_distance_mpso
from .registry import register_optimizer
from .sa_pso import SAPSO, sa_pso

__all__ = [
    "KAO_FUNG",
    "MPSO",
    "PSO",
    "SAPSO",
    "RankDistanceMPSO",
    "mpso",
    "pso",
    "rank_distance_mpso",
    "register_optimizer",
    "sa_pso",
]
