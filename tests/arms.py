"""Moves arms, and looks into environments, as only tests may."""

from types import SimpleNamespace
from typing import Any

import mujoco
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


def go_on(env: Any, periods: int, action: Any = 0.0) -> tuple:
    """Returns the answer to the last of that many steps, all with one action."""
    for _ in range(periods):
        answer = env.step(np.full(env.action_space.shape, action))
    return answer


def reported(env: Any, actions: np.ndarray) -> dict[str, np.ndarray]:
    """Returns each entry of `info`, and "reward", by name; its first index is the step."""
    answers = [env.step(action) for action in actions]
    infos = [{**answer[-1], "reward": answer[1]} for answer in answers]
    return {name: np.array([info[name] for info in infos]) for name in infos[0]}


def rewarded(env: ArmEnv, actions: np.ndarray) -> np.ndarray:
    """Returns observations and rewards, shape (steps, n)."""
    return np.array([np.append(*env.step(action)[:2]) for action in actions])


def posed(model: mujoco.MjModel, angle: Any = None, rate: Any = 0.0) -> mujoco.MjData:
    """Returns the data of a model at those angles [rad] and rates [rad/s], after `mj_forward`."""
    data = mujoco.MjData(model)
    data.qpos[:] = data.qpos if angle is None else angle
    data.qvel[:] = rate
    mujoco.mj_forward(model, data)
    return data


def mass_matrix(model: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """Returns the mass matrix [kg m²], shape (nv, nv)."""
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return full


def assert_same_states(one: dict, other: dict) -> None:
    """Compares everything that lives from step to step, to the last bit."""
    assert one.keys() == other.keys()
    assert one["config"] == other["config"]
    for name in one.keys() - {"config"}:
        np.testing.assert_array_equal(one[name], other[name], name)
