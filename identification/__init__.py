"""Offline identification of hysteresis models from measured angle-torque curves."""

from .asymmetric_fit import fit_asymmetric
from .auto import AutoFit, Candidate, identify_auto
from .baselines import BASELINES
from .bouc_wen_fit import fit_bouc_wen
from .certified import certified_fit
from .curves import Curve, load_curves, save_curves
from .direct import fit_prandtl_ishlinskii, fit_preisach
from .identify import Fit, Trial, bare, identify
from .mpso import MPSO, mpso
from .objective import CurveObjective
from .pso import KAO_FUNG, PSO, pso
from .rank_distance_mpso import RankDistanceMPSO, rank_distance_mpso
from .sa_pso import SAPSO, sa_pso

__all__ = [
    "BASELINES",
    "KAO_FUNG",
    "MPSO",
    "PSO",
    "SAPSO",
    "AutoFit",
    "Candidate",
    "Curve",
    "CurveObjective",
    "Fit",
    "RankDistanceMPSO",
    "Trial",
    "bare",
    "certified_fit",
    "fit_asymmetric",
    "fit_bouc_wen",
    "fit_prandtl_ishlinskii",
    "fit_preisach",
    "identify",
    "identify_auto",
    "load_curves",
    "mpso",
    "pso",
    "rank_distance_mpso",
    "sa_pso",
    "save_curves",
]
