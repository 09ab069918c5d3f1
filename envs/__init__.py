"""The simulated arm: composition, tasks, assist policies and their evaluation."""

from .arm_env import ArmEnv
from .model import ArmConfig, compose
from .tasks import TASKS, Task

__all__ = ["TASKS", "ArmConfig", "ArmEnv", "Task", "compose"]
