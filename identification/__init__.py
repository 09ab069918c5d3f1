"""Offline identification of hysteresis models from measured angle-torque curves."""

from .corrections.corrections import Corrections
from .corrections.cycles import averaged_cycles
from .data.curves import Curve, Curves
from .data.files import Motion, load_curves, load_motion, save_curves, save_motion
from .data.motions import Design, first_order_motions, measure, nested_motion
from .fit import Fit
from .fit_curves import Trial, fit_curves
from .fits.beside_polynomial import fit_asymmetric, fit_bouc_wen, fit_dahl, fit_duhem
from .fits.certified import bare, certified_fit
from .fits.objective import CurveObjective
from .fits.registry import register_fit
from .fits.weights import fit_hinged_stops, fit_prandtl_ishlinskii, fit_preisach
from .identify import identify
from .judging.coverage import Coverage, coverage, motion_coverage, shortfalls
from .judging.ensemble import Candidate, Ensemble, Member
from .judging.sentences import Remark
from .judging.uncertainty import Uncertainty, uncertainty
from .methods import Certified, Magnetic, Search
from .report import Identification
from .selection import Selection, select
from .swarms.variants import (
    KAO_FUNG,
    MPSO,
    OPTIMIZERS,
    PSO,
    SAPSO,
    SWARMS,
    RankDistanceMPSO,
    mpso,
    pso,
    rank_distance_mpso,
    register_optimizer,
    sa_pso,
)

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
