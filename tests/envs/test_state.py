"""Saved states continue bit for bit, and lost or diverged episodes end without harm."""

import copy
import pickle

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.policies import NoAssist
from activesuit.envs.simulation import Simulation
from activesuit.envs.vector_env import ArmVectorEnv
from arms import go_on, physics, rewarded
from helpers import assert_refused

ACTIONS = np.random.default_rng(5).uniform(-1, 1, (100, 2))


def play(env, steps):
    return rewarded(env, ACTIONS[:steps])


@pytest.fixture(scope="module")
def saved():
    """A state that tests may take apart (after a deep copy)."""
    env = ArmEnv()
    env.reset(seed=1)
    play(env, 20)
    return env.get_state()


def test_branching_from_a_saved_state():
    env = ArmEnv()
    env.reset(seed=1)
    play(env, 60)
    state = pickle.loads(pickle.dumps(env.get_state()))
    first = play(env, 80)
    env.reset(seed=9)
    env.set_state(state)
    np.testing.assert_array_equal(first, play(env, 80))
    other = ArmEnv()
    assert_refused(other.get_state, [("get_state before the first reset: call reset",)])
    other.set_state(state)  # a reset is not needed before
    for one in (copy.deepcopy(other), pickle.loads(pickle.dumps(other)), other):
        np.testing.assert_array_equal(first, play(one, 80))
    after, again = env.reset()[0], other.reset()[0]
    np.testing.assert_array_equal(after, again)


@pytest.mark.parametrize("coupling", ["rigid", "cuffs"])
def test_a_reset_returns_the_state_from_which_the_first_step_starts(coupling, monkeypatch):
    env, other = (ArmEnv("ElbowFlexion", coupling=coupling) for _ in range(2))
    env.reset(seed=2)
    monkeypatch.delattr(Simulation, "_equilibrate")  # which no step needs
    other.set_state(env.get_state())
    np.testing.assert_array_equal(play(env, 30), play(other, 30))
    assert np.abs(env.data.qpos - other.data.qpos).max() == 0


def test_state_shows_its_own_moment():
    env = ArmEnv(sensors=["encoders", "preview", "privileged"])
    env.reset(seed=0)
    observation, *_, info = go_on(env, 40, 0.5)
    state = env.get_state()
    env.reset(seed=1)
    again, reported = env.set_state(state)
    np.testing.assert_array_equal(again, observation)
    assert reported.keys() == info.keys()
    assert reported["reward_terms"] == info["reward_terms"]
    for key in info.keys() - {"reward_terms"}:
        np.testing.assert_array_equal(reported[key], info[key])


def test_state_of_another_environment_and_no_whole_state_are_refused(saved):
    rows = [
        ({"gravity": "moon"}, r"gravity='earth'.*gravity='moon'"),
        ({"control_dt": 0.02}, r"control_dt=0\.01.*control_dt=0\.02"),
        ({"task": "ElbowFlexion"}, r"task='ArmTracking'.*task='ElbowFlexion'"),
        ({"randomize": {"pressure": 0.1}}, r"randomize\.pressure=0\.0.*randomize\.pressure=0\.1"),
        ({"fatigue": True}, r"with fatigue=False, and this environment has fatigue=True"),
    ]
    assert_refused(lambda options: ArmEnv(**options).set_state(saved), rows)
    lacking = [{name: saved[name] for name in saved.keys() - {key}} for key in saved]
    rows = [
        *zip(lacking, (f"the state lacks {key}: give" for key in saved), strict=True),
        ({}, r"the state lacks config, physics, .*frames: give"),
        (None, "the state is a NoneType: give the dict"),
        (np.zeros(5), "the state is a ndarray: give the dict"),
    ]
    assert_refused(ArmEnv().set_state, rows)


def spoiled(values, index=0, value=np.nan):
    values = values.copy()
    values.flat[index] = value
    return values


JUNK = [
    ("config", lambda old: None, "the state's config is None: give the config of get_state"),
    ("config", lambda old: {"task": 1}, r"the state's config is {'task': 1}: give the config"),
    ("physics", lambda old: old.tolist(), r"physics is \[.*float64 numbers of shape"),
    ("physics", lambda old: old[:, :-1], r"physics is array.*must be float64 numbers of shape"),
    ("physics", lambda old: spoiled(old, 1, np.inf), "must be float64 numbers"),
    ("physics", lambda old: spoiled(old, 1, -1e11), "must be a motion below"),
    ("command", lambda old: "left", r"command is 'left'.* of shape \(1, 2\)"),
    ("command", lambda old: spoiled(old, 0, 1.5), r"must be .* \(1, 2\) from -1 to 1, as"),
    ("angle", lambda old: old[:, :5], r"angle is .* of shape \(1, 1001, 4\)"),
    ("angle", lambda old: spoiled(old, 9, 1e9), r"angle is .* from -6\.28319 to 6\.28319"),
    ("reflex_delay", lambda old: old[:, 1:], r"reflex_delay is .* of shape \(1, 5, 4\)"),
    ("muscle_noise", lambda old: spoiled(old, 3, 1e200), "muscle_noise is .* from -1e[+]09"),
    ("fatigued", lambda old: spoiled(old, 3, 1.1), "fatigued is .* from .* to 1,"),
    ("mean_square", lambda old: spoiled(old, 0, -1.0), "mean_square is .* from 0 to"),
    ("encoder_counts", lambda old: spoiled(old, 0, 1e300), "must be .* from -1e[+]09 to 1e[+]09"),
    ("step", lambda old: True, "step is True: it must be int64 numbers of shape"),
    ("step", lambda old: old - 10**6, "step is .* from 0 to 1e[+]09"),
    ("limit", lambda old: 0 * old, "limit is .* from 1 to 1e[+]09"),
    ("seed", lambda old: old - 2, "seed is .* from 0 to"),
    ("diverged", lambda old: ~old, "an episode that has diverged: go on from an earlier one"),
]


def test_a_spoiled_state_is_refused_and_changes_nothing(saved):
    env, twin = ArmEnv(), ArmEnv()
    for one in (env, twin):
        one.reset(seed=4)
        play(one, 5)
    for key, change, message in JUNK:
        state = copy.deepcopy(saved)
        state[key] = change(state[key])
        assert_refused(env.set_state, [(state, message)])
        np.testing.assert_array_equal(play(env, 2), play(twin, 2), f"{key}: {message}")
    np.testing.assert_array_equal(env.reset()[0], twin.reset()[0])


ACTION = np.array([0.3, -0.2])


SENSORS = ["encoders", "preview", "privileged"]


@pytest.fixture(scope="module")
def env():
    return ArmEnv(sensors=SENSORS)


def begin(env, steps):
    """Returns what the environment showed last, after a reset and some steps."""
    shown = env.reset(seed=0)
    *_, info = answer = go_on(env, steps, ACTION) if steps else shown
    return answer[0], info


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
        def reset(self):
            super().reset()
            Saboteur.periods = 80

    def diverging(self, action, step=ArmVectorEnv.step):
        Saboteur.periods -= 1
        if Saboteur.periods == 0:
            self.episodes.simulation.batch.bind("qvel")[:] = np.nan
        return step(self, action)

    monkeypatch.setattr(ArmVectorEnv, "step", diverging)
    fixed = {"motions": 2, "references": False, "adapted": False, "apart": False}
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
