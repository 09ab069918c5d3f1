"""Saved states: they continue bit for bit, and anything else is refused in one sentence."""

import copy
import pickle
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.errors import InputError

ACTIONS = np.random.default_rng(5).uniform(-1, 1, (100, 2))


def make(task="ArmTracking", **options) -> ArmEnv:
    env = gymnasium.make(f"ActiveSuit/{task}-v0", **options).unwrapped
    assert isinstance(env, ArmEnv)
    return env


def play(env, steps):
    """Returns observations and rewards, shape (steps, n)."""
    return np.array([np.append(*env.step(action)[:2]) for action in ACTIONS[:steps]])


@pytest.fixture(scope="module")
def saved():
    """A state that tests may take apart (after a deep copy)."""
    env = make()
    env.reset(seed=1)
    play(env, 20)
    return env.get_state()


def test_branching_from_a_saved_state():
    env = make()
    env.reset(seed=1)
    play(env, 60)
    state = pickle.loads(pickle.dumps(env.get_state()))
    first = play(env, 80)
    env.reset(seed=9)
    env.set_state(state)
    np.testing.assert_array_equal(first, play(env, 80))
    other = make()
    other.set_state(state)  # a reset is not needed before
    np.testing.assert_array_equal(first, play(other, 80))
    after, again = env.reset()[0], other.reset()[0]
    np.testing.assert_array_equal(after, again)


def test_state_shows_its_own_moment():
    env = make(observe="oracle")
    env.reset(seed=0)
    for _ in range(40):
        observation, *_, info = env.step(np.array([0.5, 0.5], np.float32))
    state = env.get_state()
    env.reset(seed=1)
    again, told = env.set_state(state)
    np.testing.assert_array_equal(again, observation)
    assert told.keys() == info.keys()
    for key in info.keys() - {"reward_terms"}:
        np.testing.assert_array_equal(told[key], info[key])


def test_deepcopy_and_pickle_continue_alike():
    env = make()
    env.reset(seed=1)
    play(env, 30)
    copies = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    first = play(env, 50)
    for other in copies:
        np.testing.assert_array_equal(first, play(other, 50))


def test_state_of_another_environment_is_refused(saved):
    with pytest.raises(InputError, match=r"gravity='earth'.*gravity='moon'"):
        make(gravity="moon").set_state(saved)
    with pytest.raises(InputError, match=r"control_dt=0\.01.*control_dt=0\.02"):
        make(control_dt=0.02).set_state(saved)
    with pytest.raises(InputError, match=r"ArmTrackingEnv.*ElbowFlexionEnv"):
        make("ElbowFlexion").set_state(saved)
    with pytest.raises(InputError, match=r"with fatigue=False, and this one has fatigue=True"):
        make(fatigue=True).set_state(saved)


def test_needs_a_reset_first():
    env = make()
    with pytest.raises(InputError, match="get_state before the first reset: call reset"):
        env.get_state()
    with pytest.raises(InputError, match="step before the first reset: call reset"):
        env.step(np.zeros(2))


@pytest.mark.parametrize("junk", [None, 3, "state", [1, 2], np.zeros(5)])
def test_what_is_no_dict_is_refused(junk):
    with pytest.raises(InputError, match=f"the state is a {type(junk).__name__}: give the dict"):
        make().set_state(junk)


def test_a_state_without_a_part_is_refused(saved):
    env = make()
    for key in saved:
        part = {name: value for name, value in saved.items() if name != key}
        with pytest.raises(InputError, match=f"the state lacks {key}: give"):
            env.set_state(part)
    with pytest.raises(InputError, match=r"the state lacks config, physics, .*fatigued: give"):
        env.set_state({})


def spoiled(values, index=0, value=np.nan):
    values = values.copy()
    values.flat[index] = value
    return values


JUNK = [
    ("config", lambda old: None, "the state's config is None: give that of get_state"),
    ("config", lambda old: {"task": 1}, r"the state's config is {'task': 1}: give that"),
    ("physics", lambda old: old.tolist(), r"physics is \[.*float64 numbers of shape"),
    ("physics", lambda old: old[:-1], r"physics is array.*must be float64 numbers of shape"),
    ("physics", lambda old: old.astype(np.float32), "must be float64 numbers"),
    ("physics", lambda old: spoiled(old, -1), "must be float64 numbers"),
    ("physics", lambda old: spoiled(old, 1, np.inf), "must be float64 numbers"),
    ("physics", lambda old: spoiled(old, 1, -1e11), "must be a motion below"),
    ("physics", lambda old: None, "physics is None"),
    ("actuator_force", lambda old: np.zeros((2, 3)), r"actuator_force is .* of shape \(6,\)"),
    ("previous_action", lambda old: "left", r"previous_action is 'left'.* of shape \(2,\)"),
    ("reference", lambda old: {}, r"reference is {}: it must be a Reference"),
    (
        "reference",
        lambda old: replace(old, angle=old.angle[:5]),
        r"reference\.angle is .* of shape \(1001, 4\)",
    ),
    (
        "reference",
        lambda old: replace(old, feedforward=spoiled(old.feedforward)),
        r"reference\.feedforward is ",
    ),
    ("past_torque", lambda old: old[1:], r"past_torque is .* of shape \(5, 4\)"),
    ("variation", spoiled, r"variation is .* of shape \(3, 4\)"),
    ("fatigued", lambda old: 0.0, r"fatigued is 0\.0.* of shape \(2, 4\)"),
    ("motor_heat", lambda old: None, r"motor_heat is None.* of shape \(2,\)"),
    ("physics", lambda old: spoiled(old, -1, np.inf), "must be float64 numbers"),
    ("actuator_force", lambda old: spoiled(old, 0, 1e300), "must be .* from -1e[+]09 to 1e[+]09"),
    ("previous_action", lambda old: spoiled(old, 0, 1.5), r"must be .* \(2,\) from -1 to 1, as"),
    ("previous_action", lambda old: spoiled(old, 1, -np.inf), "must be .* from -1 to 1"),
    ("past_torque", lambda old: spoiled(old, 3, -1e200), "past_torque is .* from -1e[+]09"),
    ("variation", lambda old: spoiled(old, 3, 1e200), "variation is .* from -1e[+]09"),
    ("fatigued", lambda old: spoiled(old, 3, 1.1), "fatigued is .* from .* to 1,"),
    ("motor_heat", lambda old: spoiled(old, 0, -1.0), "motor_heat is .* from 0 to"),
    (
        "reference",
        lambda old: replace(old, angle=spoiled(old.angle, 9, 1e9)),
        r"reference\.angle is .* from -6\.28319 to 6\.28319",
    ),
    (
        "reference",
        lambda old: replace(old, rate=spoiled(old.rate, 9, -np.inf)),
        r"reference\.rate is .* from -1e[+]09",
    ),
    (
        "reference",
        lambda old: replace(old, resistance=spoiled(old.resistance, 9, 1e308)),
        r"reference\.resistance is .* from -1e[+]09",
    ),
    ("step", lambda old: True, "step is True: it must be a count"),
    ("step", lambda old: 10**400, "step is 1000.*0000: it must be a count from 0 to 1000000000"),
    ("clipped_actions", lambda old: False, "clipped_actions is False: it must be a count"),
    ("energy", lambda old: {**old, "human_energy": 1e300}, "human_energy is 1e.300: .* within 1e"),
    ("step", lambda old: -1, "step is -1: it must be a count"),
    ("step", lambda old: 2.5, r"step is 2\.5: it must be a count"),
    ("clipped_actions", lambda old: "none", "clipped_actions is 'none': it must be a count"),
    ("energy", lambda old: 1.0, r"energy is 1\.0: it must be a dict of assist_energy and human"),
    ("energy", lambda old: {"assist_energy": 1.0}, "must be a dict of assist_energy and human"),
    ("energy", lambda old: {**old, "human_energy": None}, "human_energy is None: it must be a nu"),
    ("dissipated_at_reset", lambda old: np.inf, "dissipated_at_reset is inf: it must be a number"),
    ("random", lambda old: None, "random is None: it must be a generator's state"),
    ("random", lambda old: {**old, "state": {}}, "it must be a generator's state"),
    ("diverged", lambda old: True, "an episode that has diverged: go on from an earlier one"),
]


@pytest.mark.parametrize(("key", "change", "message"), JUNK)
def test_a_spoiled_state_is_refused_and_changes_nothing(saved, key, change, message):
    env, twin = make(), make()
    for one in (env, twin):
        one.reset(seed=4)
        play(one, 5)
    state = copy.deepcopy(saved)
    state[key] = change(state[key])
    with pytest.raises(InputError, match=message) as refusal:
        env.set_state(state)
    assert len(str(refusal.value).splitlines()) == 1
    np.testing.assert_array_equal(play(env, 20), play(twin, 20))
    np.testing.assert_array_equal(env.reset()[0], twin.reset()[0])
