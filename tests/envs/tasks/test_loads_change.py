"""Loads that come and go within an episode, to the last bit in rows and single environments."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.simulation.plan import Plan
from activesuit.envs.tasks import TASKS, Task
from arms import assert_same_states, state

POSTURE = np.array([0.0, 0.7, 1.0, 0.0])
PERIODS = 60


class Juggle(Task):
    """Loads are taken up and put down in every tenth of a second."""

    carries = True

    def plan(self, rng, samples, dt, arm):
        still = np.zeros((samples, 4))
        mass = np.repeat(rng.uniform(0, 3, samples // 10 + 1), 10)[:samples]
        mass[::20] = 0.0
        return Plan((still + POSTURE, still, still), mass)


@pytest.mark.parametrize("coupling", ["rigid", "cuffs"])
def test_rows_are_single_environments_through_pick_up_and_release(coupling):
    task = Juggle(name="Juggle", duration=PERIODS / 100)
    single = ArmEnv(task, coupling=coupling, level="randomized")
    arms = single.rows(2, threads=1, autoreset_mode="SameStep")
    single.reset(seed=6)
    arms.reset(seed=5)
    loads, rng = [], np.random.default_rng(0)
    for period in range(PERIODS + 30):  # into the next episode
        actions = rng.uniform(-0.2, 0.2, (2, 2))
        observation, reward, *_ = single.step(actions[1])
        shown, rewards, *_ = arms.step(actions)
        if period == PERIODS - 1:
            observation, _ = single.reset()
        np.testing.assert_array_equal(observation, shown[1])
        assert reward == rewards[1]
        loads.append((state(single).load[0], arms.episodes.simulation.state.conditions.load[1]))
    alone, row = np.array(loads).T
    np.testing.assert_array_equal(alone, row)
    loaded = alone[:PERIODS] > 0
    assert loaded.any()
    assert np.diff(loaded.astype(int)).min() == -1  # put down within the episode
    assert_same_states(single.get_state(), arms.get_state(rows=[1]))


def test_loads_are_those_of_the_plan():
    env = ArmEnv(Juggle(name="Juggle", duration=1.0), coupling="none", payload={"mass": 0.5})
    env.reset(seed=3)
    carried = state(env).carried[0].copy()
    for period in range(100):
        env.step(np.zeros(0))
        assert state(env).load[0] == carried[period]
    assert carried.min() == 0.5  # the payload stays in the hand
    assert np.ptp(carried) > 1


@pytest.mark.parametrize("name", ["Scoop", "Handrail"])
def test_randomize_load_multiplies_masses_and_pushes(name):
    task = replace(TASKS[name], duration=1.0)
    plain, drawn = (ArmEnv(task, coupling="none", randomize={"load": share}) for share in (0, 0.5))
    factors = []
    for seed in range(12):
        loads = []
        for env in (plain, drawn):
            env.reset(seed=seed)
            own = state(env).push if name == "Handrail" else state(env).carried
            loads.append(own[0].copy())
            angle = state(env).angle[0].copy()
        np.testing.assert_array_equal(angle, state(plain).angle[0])  # the motion is the same
        there = loads[0] != 0
        ratio = loads[1][there] / loads[0][there]
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-12)
        np.testing.assert_array_equal(loads[1][~there], 0.0)
        factors.append(ratio[0])
    assert 0.5 <= min(factors) < 0.8
    assert 1.2 < max(factors) <= 1.5
