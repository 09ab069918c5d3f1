"""Looks into environments, as only tests may."""

from types import SimpleNamespace

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.person import Person
from activesuit.envs.simulation.structs import Addresses

PEOPLE = [  # the usual one, two of the survey, and both ends of what is allowed
    Person(),
    Person.percentile("female", 5),
    Person.percentile("male", 95),
    Person(stature=1.4, mass=40.0, sex="female", strength=1.0),
    Person(stature=2.1, mass=140.0, strength=99.0),
]


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
