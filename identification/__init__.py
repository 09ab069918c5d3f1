"""Offline identification of hysteresis models from measured angle-torque curves."""

from .asymmetric_fit import fit_asymmetric
from .auto import Candidate
from .baselines import BASELINES
from .bouc_wen_fit import fit_bouc_wen
from .certified import certified_fit
from .curves import Curve, load_curves, save_curves
from .direct import fit_prandtl_ishlinskii, fit_preisach
from .identify import Fit, Trial, identify
from .mpso import MPSO, mpso
from .objective import CurveObjective
from .own_fits import bare
from .pso import KAO_FUNG, PSO, pso
from .rank_distance_mpso import RankDistanceMPSO, rank_distance_mpso
from .sa_pso import SAPSO, sa_pso
from .synthetic import first_order_motions, measure, multi_order_motion
from .uncertainty import Uncertainty, uncertainty

__all__ = [
    "BASELINES",
    "KAO_FUNG",
    "MPSO",
    "PSO",
    "SAPSO",
    "Candidate",
    "Curve",
    "CurveObjective",
    "Fit",
    "RankDistanceMPSO",
    "Trial",
    "Uncertainty",
    "bare",
    "certified_fit",
    "first_order_motions",
    "fit_asymmetric",
    "fit_bouc_wen",
    "fit_prandtl_ishlinskii",
    "fit_preisach",
    "identify",
    "load_curves",
    "measure",
    "mpso",
    "multi_order_motion",
    "pso",
    "rank_distance_mpso",
    "sa_pso",
    "save_curves",
    "uncertainty",
]
