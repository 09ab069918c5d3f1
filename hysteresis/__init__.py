"""Hysteresis models of joint torque: kernels, certificates, and (in `.engine`) the MuJoCo plugin.

Angles are radians and torques N·m throughout. Nothing here imports MuJoCo but `.engine`.
"""

from .around.asymmetric import Asymmetric
from .around.held import Held
from .bouc_wen.model import BoucWen
from .certificate import Certificate, PoleError, UncertifiedModelError
from .jiles_atherton.model import JilesAtherton
from .jiles_atherton.nearest import nearest_certified
from .jiles_atherton.table_2 import TABLE_2
from .prandtl_ishlinskii.model import PrandtlIshlinskii
from .preisach.model import Preisach
from .protocol import Energy, HysteresisModel, State
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
