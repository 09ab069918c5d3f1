"""Looks into environments, as only tests may."""

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.simulation.addresses import Addresses
from activesuit.envs.simulation.memory import Memory


def physics(env: ArmEnv, name: str) -> np.ndarray:
    """Returns a field of MjData that belongs to the state, as a view that may be written."""
    return env.episodes.simulation.batch.bind(name)[0]


def addresses(env: ArmEnv) -> Addresses:
    return env.episodes.simulation.addresses


def memory(env: ArmEnv) -> Memory:
    return env.episodes.simulation.memory
