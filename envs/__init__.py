"""The simulated arm: composition, tasks, assist policies and their evaluation."""

from .arm_env import ArmEnv
from .model import ArmConfig, compose
from .setup import Setup
from .tasks import TASKS, Task

__all__ = ["TASKS", "ArmConfig", "ArmEnv", "Setup", "Task", "compose"]
