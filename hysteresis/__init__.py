"""Hysteresis models of joint torque: kernels, certificates, and (in `.engine`) the MuJoCo plugin.

Angles are radians and torques N·m throughout. Nothing here imports MuJoCo but `.engine`.
"""

from .asymmetric import Asymmetric
from .bouc_wen import BoucWen
from .certificate import Certificate, PoleError, UncertifiedModelError
from .held import Held
from .jiles_atherton import JilesAtherton
from .model import Energy, HysteresisModel, State
from .nearest import nearest_certified
from .prandtl_ishlinskii import PrandtlIshlinskii
from .preisach import Preisach
from .published import TABLE_2
from .registry import MODELS, model_from_dict

__all__ = [
    "MODELS",
    "TABLE_2",
    "Asymmetric",
    "BoucWen",
    "Certificate",
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
]
