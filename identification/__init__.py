"""Offline identification of hysteresis models from measured angle-torque curves."""

from .certified import certified_fit
from .curves import Curve, load_curves, save_curves
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
    "identify",
    "load_curves",
    "mpso",
    "pso",
    "sa_pso",
    "save_curves",
]
