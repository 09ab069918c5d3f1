"""The simulated arm: composition, tasks, assist policies and their evaluation."""

from .arm_env import ArmEnv
from .model import ArmConfig, compose
from .tasks import ArmTrackingEnv, ElbowFlexionEnv, ShoulderFlexionEnv

__all__ = [
    "ArmConfig",
    "ArmEnv",
    "ArmTrackingEnv",
    "ElbowFlexionEnv",
    "ShoulderFlexionEnv",
    "compose",
]
