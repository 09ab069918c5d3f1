"""Offline identification of hysteresis models from measured angle-torque curves."""

from .curves import Curve, load_curves, save_curves
from .fits.asymmetric import fit_asymmetric
from .fits.bouc_wen import fit_bouc_wen
from .fits.certified import certified_fit
from .fits.linear import fit_prandtl_ishlinskii, fit_preisach
from .fits.registry import bare
from .identify import Fit, Trial, identify
from .objective import CurveObjective
from .optimizers.libraries import BASELINES
from .optimizers.mpso import MPSO, mpso
from .optimizers.pso import KAO_FUNG, PSO, pso
from .optimizers.rank_distance_mpso import RankDistanceMPSO, rank_distance_mpso
from .optimizers.sa_pso import SAPSO, sa_pso
from .selection import Candidate
from .synthetic import first_order_motions, measure, multi_order_motion
from .uncertainty.uncertainty import Uncertainty, uncertainty

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
