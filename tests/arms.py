"""Looks into environments, as only tests may."""

from types import SimpleNamespace

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.simulation.addresses import Addresses


def physics(env: ArmEnv, name: str) -> np.ndarray:
    """Returns a field of MjData that belongs to the state, as a view that may be written."""
    return env.episodes.simulation.batch.bind(name)[0]


def addresses(env: ArmEnv) -> Addresses:
    return env.episodes.simulation.addresses


def state(env: ArmEnv) -> SimpleNamespace:
    """Returns the arrays of the episode's state by name, which may be written."""
    return SimpleNamespace(**env.episodes.simulation.state.arrays())


def assert_same_states(one: dict, other: dict) -> None:
    """Compares everything that lives from step to step, to the last bit."""
    assert one.keys() == other.keys()
    assert one["config"] == other["config"]
    for name in one.keys() - {"config"}:
        np.testing.assert_array_equal(one[name], other[name], name)
