"""Hysteresis models of joint torque: kernels, certificates, and (in `.engine`) the MuJoCo plugin.

Angles are radians and torques N·m throughout. Nothing here imports MuJoCo but `.engine`.
"""

from .around import Asymmetric, Held
from .bouc_wen import BoucWen
from .certificate import Certificate, PoleError, UncertifiedModelError
from .config import ConfigKey
from .jiles_atherton import TABLE_2, JilesAtherton, nearest_certified
from .prandtl_ishlinskii import PrandtlIshlinskii
from .preisach import Preisach
from .protocol import Energy, HysteresisModel, State
from .registry import MODELS, model_from_dict, register_model

__all__ = [
    "MODELS",
    "TABLE_2",
    "Asymmetric",
    "BoucWen",
    "Certificate",
    "ConfigKey",
    "Energy",
    "Held",
    "HysteresisModel",
    "JilesAtherton",
    "PoleError",
    "PrandtlIshlinskii",
    "Preisach",
    "State",
    "UncertifiedModelError",
    "model_from_dict",
    "nearest_certified",
    "register_model",
]
