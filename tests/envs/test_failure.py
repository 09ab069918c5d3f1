"""Lost and diverged episodes: they end, and no number of theirs would poison a learner."""

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.policies import NoAssist
from activesuit.envs.vector_env import ArmVectorEnv
from arms import physics
from helpers import assert_refused

ACTION = np.array([0.3, -0.2])


SENSORS = ["encoders", "preview", "privileged"]


@pytest.fixture(scope="module")
def env():
    return ArmEnv(sensors=SENSORS)


def begin(env, steps):
    """Returns what the environment showed last, after a reset and some steps."""
    observation, info = env.reset(seed=0)
    for _ in range(steps):
        observation, *_, info = env.step(ACTION)
    return observation, info


def assert_finite(observation, reward, info):
    assert np.isfinite(observation).all() and 0 <= reward <= 1
    assert np.isfinite(list(info["reward_terms"].values())).all()
    assert np.isfinite(list(info["cost_terms"].values())).all()
    for key in info.keys() - {"reward_terms", "cost_terms"}:
        assert np.isfinite(info[key]).all(), key


@pytest.mark.parametrize(("value", "steps"), [(np.nan, 0), (np.inf, 30), (1e6, 30)])
def test_divergence_ends_the_episode_with_what_was_valid_last(env, value, steps):
    observation, info = begin(env, steps)
    assert not info["diverged"]
    physics(env, "qvel")[2] = value
    shown, reward, terminated, truncated, reported = env.step(ACTION)
    assert (terminated, truncated, reward) == (True, False, 0)
    assert reported["diverged"]
    assert_finite(shown, reward, reported)
    np.testing.assert_array_equal(shown, observation)
    assert reported.keys() == info.keys()
    assert reported["time"] == pytest.approx(info["time"] + 0.01)
    changed = {"time", "diverged", "reward_terms", "cost_terms", "is_success"}
    assert not reported["is_success"]
    for key in info.keys() - changed:
        np.testing.assert_array_equal(reported[key], info[key])


@pytest.mark.parametrize(
    "part",
    ["qpos", "qvel", "act", "qfrc_applied", pytest.param("plugin_state", marks=pytest.mark.slow)],
)
def test_whatever_is_spoiled_all_numbers_stay_finite(env, part):
    begin(env, 5)
    state = env.get_state()
    for i in range(physics(env, part).size):
        env.set_state(state)
        physics(env, part)[i] = np.nan
        observation, reward, terminated, _, info = env.step(ACTION)
        assert terminated or part == "plugin_state"  # where not every motion needs every number
        assert_finite(observation, reward, info)


def test_what_the_caller_does_to_an_answer_stays_with_the_caller(env):
    observation, info = begin(env, 5)
    kept, angle = observation.copy(), info["angle"].copy()
    observation[:] = np.nan
    info["angle"][:] = np.nan
    physics(env, "qvel")[0] = np.nan
    for _ in range(2):  # it stays diverged
        shown, *_, reported = env.step(ACTION)
        np.testing.assert_array_equal(shown, kept)
        np.testing.assert_array_equal(reported["angle"], angle)
        shown[:] = np.nan
        reported["angle"][:] = np.nan


def test_after_divergence_a_reset_or_an_earlier_state_goes_on(env):
    twin = ArmEnv(sensors=SENSORS)
    begin(env, 10)
    state = env.get_state()
    expected = env.step(ACTION)[0]
    physics(env, "qvel")[1] = np.nan
    env.step(ACTION)
    message = "episode that has diverged: go on from an earlier one"
    assert_refused(env.set_state, [(env.get_state(), message)])
    assert not env.set_state(state)[1]["diverged"]
    observation, _, terminated, _, info = env.step(ACTION)
    np.testing.assert_array_equal(observation, expected)
    assert not terminated and not info["diverged"]
    physics(env, "qvel")[1] = np.nan
    env.step(ACTION)
    for one in (env, twin):
        begin(one, 3)
    first, second = env.step(ACTION), twin.step(ACTION)
    np.testing.assert_array_equal(first[0], second[0])
    assert first[1:4] == second[1:4]


@pytest.mark.parametrize(("part", "joint", "value"), [("qpos", 1, 2.5), ("qvel", 2, 1e3)])
def test_a_lost_arm_ends_the_episode_and_earns_nothing(env, part, joint, value):
    begin(env, 5)
    physics(env, part)[joint] = value
    observation, reward, terminated, _, info = env.step(ACTION)
    assert (terminated, reward) == (True, 0)
    assert not info["diverged"] and not info["is_success"]
    assert_finite(observation, reward, info)
    assert info["reward_terms"]["tracking"] > 25  # a rad at one of four joints


def test_a_diverged_episode_is_scored_as_failed(monkeypatch):
    class Saboteur(NoAssist):
        """Lets the arm diverge after some periods."""

        def reset(self):
            super().reset()
            Saboteur.periods = 80

    def diverging(self, action, step=ArmVectorEnv.step):
        Saboteur.periods -= 1
        if Saboteur.periods == 0:
            self.episodes.simulation.batch.bind("qvel")[:] = np.nan
        return step(self, action)

    monkeypatch.setattr(ArmVectorEnv, "step", diverging)
    fixed = {"motions": 2, "references": False, "adapted": False}
    policies = {"none": "none", "saboteur": Saboteur}
    Saboteur.periods = -1
    found = evaluate("ActiveSuit/ElbowFlexion-v0", policies, **fixed).scores
    result = found["saboteur"]
    assert result.failures == 2 and result.success == (False, False)
    for by_joint in (result.human_rms, result.peak, result.tracking_rmse):
        assert np.isfinite(list(by_joint.values())).all()
    assert np.isfinite([result.assist_energy, result.reward]).all()
    # What is lost early earns nothing more.
    assert max(result.reward) < 0.2 * min(found["none"].reward)
