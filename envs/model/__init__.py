"""The simulated arm as a MuJoCo model: a person, a suit, and an exoskeleton that fits both."""

from .compose import (
    arm_spec,
    bare_arm,
    compose,
    for_warp,
    load_model,
    resisting_joints,
    suit_of_config,
)
from .config import GRAVITY, ArmConfig, Payload
from .encoders import start_encoders
from .exoskeleton import ASSISTED, Exo
from .motors import Motor
from .variants import mirror

__all__ = [
    "ASSISTED",
    "GRAVITY",
    "ArmConfig",
    "Exo",
    "Motor",
    "Payload",
    "arm_spec",
    "bare_arm",
    "compose",
    "for_warp",
    "load_model",
    "mirror",
    "resisting_joints",
    "start_encoders",
    "suit_of_config",
]
