"""Offline identification of hysteresis models from measured angle-torque curves."""

from .candidates import Candidate
from .corrections import Corrections
from .coverage import Coverage, coverage, motion_coverage, shortfalls
from .curve_files import load_curves, save_curves
from .curves import Curve, Curves
from .cycles import averaged_cycles
from .design import Design, nested_motion
from .ensemble import Ensemble, Member
from .fit import Fit
from .fit_curves import fit_curves
from .fits.asymmetric import fit_asymmetric
from .fits.beginning import bare
from .fits.bouc_wen import fit_bouc_wen
from .fits.certified import certified_fit
from .fits.dahl import fit_dahl, fit_duhem
from .fits.hinged_stops import fit_hinged_stops
from .fits.linear import fit_prandtl_ishlinskii, fit_preisach
from .fits.registry import register_fit
from .identify import identify
from .methods import Certified, Magnetic, Search
from .motion_files import Motion, load_motion, save_motion
from .objective import CurveObjective
from .optimizers.mpso import MPSO, mpso
from .optimizers.pso import KAO_FUNG, PSO, pso
from .optimizers.rank_distance_mpso import RankDistanceMPSO, rank_distance_mpso
from .optimizers.registry import OPTIMIZERS, SWARMS, register_optimizer
from .optimizers.sa_pso import SAPSO, sa_pso
from .remarks import Remark
from .report import Identification
from .selection import Selection, select
from .synthetic import first_order_motions, measure, multi_order_motion
from .trials import Trial
from .uncertainty.uncertainty import Uncertainty, uncertainty

__all__ = [
    "KAO_FUNG",
    "MPSO",
    "OPTIMIZERS",
    "PSO",
    "SAPSO",
    "SWARMS",
    "Candidate",
    "Certified",
    "Corrections",
    "Coverage",
    "Curve",
    "CurveObjective",
    "Curves",
    "Design",
    "Ensemble",
    "Fit",
    "Identification",
    "Magnetic",
    "Member",
    "Motion",
    "RankDistanceMPSO",
    "Remark",
    "Search",
    "Selection",
    "Trial",
    "Uncertainty",
    "averaged_cycles",
    "bare",
    "certified_fit",
    "coverage",
    "first_order_motions",
    "fit_asymmetric",
    "fit_bouc_wen",
    "fit_curves",
    "fit_dahl",
    "fit_duhem",
    "fit_hinged_stops",
    "fit_prandtl_ishlinskii",
    "fit_preisach",
    "identify",
    "load_curves",
    "load_motion",
    "measure",
    "motion_coverage",
    "mpso",
    "multi_order_motion",
    "nested_motion",
    "pso",
    "rank_distance_mpso",
    "register_fit",
    "register_optimizer",
    "sa_pso",
    "save_curves",
    "save_motion",
    "select",
    "shortfalls",
    "uncertainty",
]
