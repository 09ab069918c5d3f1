"""Wearers in closed loop: how they begin, what they learn, and what they forget."""

from dataclasses import dataclass
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import rollout
from activesuit.envs.evaluation.wearers import Wearers, smoothed
from activesuit.envs.person.control import FORGETTING, RATE
from activesuit.envs.policies import make_policy
from activesuit.envs.tasks import ARM_TRACKING, RandomMoves
from activesuit.envs.vector_env import ArmVectorEnv
from arms import addresses, state

MOVED = [JOINTS.index("shoulder_flexion"), JOINTS.index("elbow_flexion")]
CREDIT = 10  # control periods between what was missing and what is given more of


@dataclass(frozen=True, kw_only=True)
class Again(RandomMoves):
    """The same motion in every episode."""

    def motion(self, rng, samples, dt):
        return super().motion(np.random.default_rng(5), samples, dt)


STILL = RandomMoves(
    name="Still", hold={"shoulder_flexion": (0.8, 0.9), "elbow_flexion": (0.8, 0.9)}, duration=2.0
)
AGAIN = Again(name="Again", span=ARM_TRACKING.span, duration=4.0)
MOTION = "Test/Again-v0"


@pytest.fixture(scope="module", autouse=True)
def registered():
    gymnasium.register(MOTION, entry_point=ArmEnv, kwargs={"task": AGAIN})
    yield
    del gymnasium.registry[MOTION]


def episode(env, action=None):
    """Returns the tracking error of a whole episode [rad], shape (periods, 4), and its rewards."""
    action = np.zeros(env.action_space.shape) if action is None else action
    errors, rewards, over = [], [], False
    while not over:
        _, reward, ended, over, info = env.step(action)
        assert not ended
        errors.append(info["target_angle"] - info["angle"])
        rewards.append(reward)
    return np.array(errors), np.array(rewards)


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


# --- Learning -----------------------------------------------------------------------------------


def repeated(env, times):
    errors = []
    for _ in range(times):
        env.reset()
        errors.append(episode(env)[0][:, MOVED])
    return errors


@pytest.fixture(scope="module")
def practised():
    """A wearer who has repeated a motion in the suit, and the errors of each time."""
    env = ArmEnv(AGAIN, coupling="none", gravity="microgravity")
    env.reset(seed=0)
    return SimpleNamespace(env=env, errors=[episode(env)[0][:, MOVED], *repeated(env, 11)])


def test_errors_fall_from_episode_to_episode(practised):
    sizes = [rms(error) for error in practised.errors]
    assert sizes[4] < 0.6 * sizes[0]
    assert sizes[-1] < 0.45 * sizes[0]


def test_after_effects_point_the_other_way_and_are_forgotten(practised):
    options = {"coupling": "none", "gravity": "microgravity"}
    bare = ArmEnv(AGAIN, suit="none", **options)
    bare.reset(seed=0)
    before, _ = episode(bare)
    state(bare).next_gains[:] = state(practised.env).next_gains  # the suit is taken off
    errors = repeated(bare, 12)
    loaded = practised.errors[0]
    usual = before[:, MOVED]
    first = errors[0] - usual
    assert np.sum(first * (loaded - usual)) < -0.2 * np.sum((loaded - usual) ** 2)
    assert rms(errors[-1] - usual) < 0.4 * rms(first)


def test_who_never_learns_repeats_the_same_errors():
    env = ArmEnv(AGAIN, control={"adaptation": 0.0})
    env.reset(seed=0)
    first, *others = [episode(env)[0], *repeated(env, 1)]
    np.testing.assert_array_equal(first[:, MOVED], others[0])
    assert state(env).gains.size == 0


def test_a_seed_forgets_and_no_seed_remembers(practised):
    env = ArmEnv(AGAIN, coupling="none", gravity="microgravity")
    env.reset(seed=0)
    episode(env)
    kept = state(env).next_gains.copy()
    assert not state(env).gains.any()  # what was learned is foreseen in the next episode
    env.reset()
    np.testing.assert_array_equal(state(env).gains, kept)
    assert kept.any()
    env.reset(seed=0)
    assert not state(env).gains.any()
    np.testing.assert_array_equal(episode(env)[0][:, MOVED], practised.errors[0])


# --- Adapted wearers ----------------------------------------------------------------------------

SCENE = {"coupling": "none", "gravity": "microgravity", "threads": 1}


@pytest.fixture(scope="module")
def learned():
    """Errors of repetitions with the law of learning, the torque after them, and its limit."""
    wearers = Wearers(MOTION, 1, **SCENE)
    policy = make_policy("none", wearers.arms)
    traces = wearers.unadapted(policy, [0])
    simulation = wearers.arms.episodes.simulation
    own, learned_torque = simulation.own_torque(np.array([0])), 0.0
    errors = []
    for _ in range(31):
        (trace,) = traces
        errors.append(rms((trace.angle - trace.target_angle)[:, MOVED]))
        answer = smoothed([trace.human_torque], own.shape[1]) - own - learned_torque
        late = np.concatenate([answer[:, CREDIT:], answer[:, -1:].repeat(CREDIT, 1)], axis=1)
        learned_torque = (1 - FORGETTING) * learned_torque + RATE * late
        traces = rollout(wearers.arms, policy, [0], learned={"learned_torque": learned_torque})
    lesson = wearers.learned_torque(lambda: policy, [0])
    wearers.close()
    return SimpleNamespace(errors=errors, torque=learned_torque, lesson=lesson)


def test_the_error_of_a_repeated_motion_falls_to_a_quarter_in_10_to_30(learned):
    below = np.flatnonzero(np.array(learned.errors) < 0.25 * learned.errors[0])
    assert 10 <= below[0] <= 30


def test_the_adapted_wearer_is_the_limit_of_the_law(learned):
    off = learned.torque - learned.lesson
    assert rms(off[..., MOVED]) < 0.1 * rms(learned.lesson[..., MOVED])


@pytest.fixture(scope="module")
def adapted():
    """Motions of adapted wearers under two policies, after two and three guided rollouts."""
    found = {}
    for name in ("none", "compensation"):
        wearers = Wearers(MOTION, 1, threads=1)
        policy = make_policy(name, wearers.arms)
        for rollouts in (2, 3):
            learned_torque = wearers.learned_torque(
                lambda policy=policy: policy, [0], rollouts=rollouts
            )
            (found[name, rollouts],) = rollout(
                wearers.arms, policy, [0], learned={"learned_torque": learned_torque}
            )
        wearers.close()
    return found


@pytest.mark.parametrize(("name", "change"), [("none", 0.002), ("compensation", 0.03)])
def test_another_guided_repetition_changes_little(adapted, name, change):
    two, three = (rms(adapted[name, rollouts].effort) for rollouts in (2, 3))
    assert three == pytest.approx(two, rel=change)


def test_who_has_learned_the_exoskeleton_gains_from_it(adapted):
    off, assisted = adapted["none", 2], adapted["compensation", 2]
    assert rms(assisted.human_torque) < 0.5 * rms(off.human_torque)
    assert rms(assisted.angle - assisted.target_angle) < 0.01  # rad


# --- Beginnings ---------------------------------------------------------------------------------


@pytest.mark.parametrize("coupling", ["rigid", "cuffs"])
def test_motors_begin_with_the_first_action_and_the_arm_stays(coupling):
    env = ArmEnv(STILL, coupling=coupling, control={"adaptation": 0.0})
    gravity = make_policy("gravity", env)
    for first in (None, np.array([0.2, -0.1])):
        observation, info = env.reset(seed=3)
        action = gravity.act(observation) if first is None else first
        wanted = action * addresses(env).peak_torque
        assert np.abs(wanted).max() > 3
        *_, info = env.step(action)
        np.testing.assert_allclose(info["assist_torque"], wanted, rtol=1e-6, atol=1e-9)
    observation, info = env.reset(seed=3)
    for _ in range(20):
        observation, *_, info = env.step(gravity.act(observation))
        assert np.abs(info["angle"] - info["target_angle"]).max() < 0.001


def test_the_first_half_second_decides_no_score():
    for name in ("none", "gravity"):
        arms = ArmVectorEnv(8, threads=1)
        traces = rollout(arms, make_policy(name, arms), range(8))
        rewards = np.sum([trace.rewards for trace in traces], axis=0)
        assert 0.03 < rewards[:50].sum() / rewards.sum() < 0.08
