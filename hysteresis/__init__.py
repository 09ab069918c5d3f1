"""Hysteresis models of joint torque, with certificates; `.engine` puts them into MuJoCo.

Angles are in radians and torques in N·m throughout. Only `.engine` imports MuJoCo.
"""

from . import first_use  # noqa: F401  (reports long compilation)
from .around import Asymmetric, Backlash, Held, Viscoelastic
from .bouc_wen import BoucWen
from .certificate import Certificate, PoleError, UncertifiedModelError
from .config import ConfigKey
from .hinged_stops import HingedStops
from .jiles_atherton import TABLE_2, JilesAtherton, nearest_certified
from .prandtl_ishlinskii import PrandtlIshlinskii
from .preisach import Preisach
from .protocol import Energy, HysteresisModel, State
from .registry import MODELS, model_from_dict, register_model
from .steady import SteadyCycle, steady_cycle

__all__ = [
    "MODELS",
    "TABLE_2",
    "Asymmetric",
    "Backlash",
    "BoucWen",
    "Certificate",
    "ConfigKey",
    "Energy",
    "Held",
    "HingedStops",
    "HysteresisModel",
    "JilesAtherton",
    "PoleError",
    "PrandtlIshlinskii",
    "Preisach",
    "State",
    "SteadyCycle",
    "UncertifiedModelError",
    "Viscoelastic",
    "model_from_dict",
    "nearest_certified",
    "register_model",
    "steady_cycle",
]
