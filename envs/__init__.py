"""The simulated arm: composition, tasks, assist policies and their evaluation.

    >>> env = ArmEnv("ArmTracking", suit="mock-suit")
    >>> observation, info = env.reset(seed=0)
    >>> for _ in range(10):
    ...     observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    >>> observation in env.observation_space
    True

A value that cannot be used raises an `InputError`, whose sentence names the value, what is allowed
and what to do.
"""

from .arm_env import ArmEnv
from .model import ArmConfig, compose
from .setup import Setup
from .tasks import TASKS, Task

__all__ = ["TASKS", "ArmConfig", "ArmEnv", "Setup", "Task", "compose"]
