"""Hysteresis models of joint torque: kernels, certificates, and (in `.engine`) the MuJoCo plugin.

Angles are radians and torques N·m throughout. Nothing here imports MuJoCo but `.engine`.
"""

from .certificate import Certificate, PoleError, UncertifiedModelError
from .jiles_atherton import JilesAtherton, JilesAthertonState

__all__ = [
    "Certificate",
    "JilesAtherton",
    "JilesAthertonState",
    "PoleError",
    "UncertifiedModelError",
]
