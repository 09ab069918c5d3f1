"""Offline identification of hysteresis models from measured angle-torque curves."""

from .certified import certified_fit
from .curves import Curve, load_curves, save_curves
from .direct import fit_prandtl_ishlinskii, fit_preisach
from .identify import Fit, Trial, identify
from .mpso import mpso
from .objective import CurveObjective
from .pso import pso
from .sa_pso import sa_pso

__all__ = [
    "Curve",
    "CurveObjective",
    "Fit",
    "Trial",
    "certified_fit",
    "fit_prandtl_ishlinskii",
    "fit_preisach",
    "identify",
    "load_curves",
    "mpso",
    "pso",
    "sa_pso",
    "save_curves",
]
