"""Hysteresis models of joint torque, with certificates; `.engine` puts them into MuJoCo.

Angles are in radians and torques in N·m throughout. Only `.engine` imports MuJoCo.
"""

from . import first_use  # noqa: F401  (reports long compilation)
from .around import Asymmetric, Backlash, Clipped, Viscoelastic
from .bouc_wen import BoucWen
from .certificate import Certificate, PoleError, UncertifiedModelError
from .dahl import Dahl, Duhem
from .jiles_atherton import TABLE_2, JilesAtherton, nearest_certified
from .preisach import Preisach
from .protocol import ConfigKey, Energy, HysteresisModel, State
from .registry import MODELS, model_from_dict, register_model
from .steady import SteadyCycle, steady_cycle
from .stops import HingedStops, PrandtlIshlinskii

_RENAMED = {"Held": "Clipped"}


def __getattr__(name: str) -> object:
    if name in _RENAMED:
        raise ImportError(f"{name!r} was a name of version 0.2: write {_RENAMED[name]!r} instead")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "MODELS",
    "TABLE_2",
    "Asymmetric",
    "Backlash",
    "BoucWen",
    "Certificate",
    "Clipped",
    "ConfigKey",
    "Dahl",
    "Duhem",
    "Energy",
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
