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


BENT = {"shoulder_flexion": (0.8, 0.9), "elbow_flexion": (0.8, 0.9)}
STILL = RandomMoves(name="Still", hold=BENT, duration=2.0)
AGAIN = Again(name="Again", span=ARM_TRACKING.span, duration=4.0)
MOTION = "Test/Again-v0"


@pytest.fixture(scope="module", autouse=True)
def registered():
    gymnasium.register(MOTION, entry_point=ArmEnv, kwargs={"task": AGAIN})
    yield
    del gymnasium.registry[MOTION]


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


# --- Learning -----------------------------------------------------------------------------------

PLACE = {"coupling": "none", "gravity": "microgravity"}


def repeated(env, times):
    """Returns the tracking errors of whole episodes [rad], shape (periods, 2) each."""
    found = []
    for _ in range(times):
        errors, over = [], False
        if found:
            env.reset()
        while not over:
            *_, ended, over, info = env.step(np.zeros(env.action_space.shape))
            assert not ended
            errors.append(info["target_angle"] - info["angle"])
        found.append(np.array(errors)[:, MOVED])
    return found


@pytest.fixture(scope="module")
def practised():
    """A wearer who has repeated a motion in the suit, and the errors of each time."""
    env = ArmEnv(AGAIN, **PLACE)
    env.reset(seed=0)
    return SimpleNamespace(env=env, errors=repeated(env, 12))


def test_errors_fall_and_after_effects_point_the_other_way_and_are_forgotten(practised):
    sizes = [rms(error) for error in practised.errors]
    assert sizes[4] < 0.6 * sizes[0] and sizes[-1] < 0.45 * sizes[0]
    bare = ArmEnv(AGAIN, suit="none", **PLACE)
    bare.reset(seed=0)
    (usual,) = repeated(bare, 1)
    state(bare).next_gains[:] = state(practised.env).next_gains  # the suit is taken off
    bare.reset()
    errors = repeated(bare, 12)
    loaded, first = practised.errors[0] - usual, errors[0] - usual
    assert np.sum(first * loaded) < -0.2 * np.sum(loaded**2)
    assert rms(errors[-1] - usual) < 0.4 * rms(first)


def test_a_seed_forgets_and_no_seed_remembers_if_the_wearer_ever_learns(practised):
    env, never = ArmEnv(AGAIN, **PLACE), ArmEnv(AGAIN, control={"adaptation": 0.0})
    never.reset(seed=0)
    np.testing.assert_array_equal(*repeated(never, 2))
    assert state(never).gains.size == 0
    env.reset(seed=0)
    repeated(env, 1)
    kept = state(env).next_gains.copy()
    assert not state(env).gains.any()  # what was learned is foreseen in the next episode
    env.reset()
    np.testing.assert_array_equal(state(env).gains, kept)
    assert kept.any()
    env.reset(seed=0)
    assert not state(env).gains.any()
    np.testing.assert_array_equal(repeated(env, 1)[0], practised.errors[0])


# --- Adapted wearers ----------------------------------------------------------------------------


def test_the_adapted_wearer_is_the_limit_of_the_law():
    """Whose error of a repeated motion falls to a quarter in 10 to 30 repetitions."""
    wearers = Wearers(MOTION, 1, threads=1, **PLACE)
    policy = make_policy("none", wearers.arms)
    traces = wearers.unadapted(policy, [0])
    own, learned = wearers.arms.episodes.simulation.own_torque(np.array([0])), 0.0
    errors = []
    for _ in range(31):
        (trace,) = traces
        errors.append(rms((trace.angle - trace.target_angle)[:, MOVED]))
        answer = smoothed([trace.human_torque], own.shape[1]) - own - learned
        late = np.concatenate([answer[:, CREDIT:], answer[:, -1:].repeat(CREDIT, 1)], axis=1)
        learned = (1 - FORGETTING) * learned + RATE * late
        traces = rollout(wearers.arms, policy, [0], learned={"learned_torque": learned})
    assert 10 <= np.flatnonzero(np.array(errors) < 0.25 * errors[0])[0] <= 30
    lesson = wearers.learned_torque(lambda: policy, [0])[..., MOVED]
    assert rms(learned[..., MOVED] - lesson) < 0.1 * rms(lesson)
    wearers.close()


def test_who_has_learned_the_exoskeleton_gains_from_it_and_little_more_from_a_repetition():
    """After two and three guided rollouts."""
    found = {}
    for name, change in (("none", 0.002), ("compensation", 0.03)):
        wearers = Wearers(MOTION, 1, threads=1)
        policy, traces = make_policy(name, wearers.arms), []
        for rollouts in (2, 3):
            lesson = wearers.learned_torque(lambda made=policy: made, [0], rollouts=rollouts)
            traces += rollout(wearers.arms, policy, [0], learned={"learned_torque": lesson})
        wearers.close()
        two, three = (rms(trace.effort) for trace in traces)
        assert three == pytest.approx(two, rel=change)
        found[name] = traces[0]
    off, assisted = found["none"], found["compensation"]
    assert rms(assisted.human_torque) < 0.5 * rms(off.human_torque)
    assert rms(assisted.angle - assisted.target_angle) < 0.01  # rad


# --- Beginnings ---------------------------------------------------------------------------------


# Cuffs bear nothing yet when the wearer gives up torque, so that the arm yields [rad].
YIELDS = {"rigid": 0.001, "cuffs": 0.015}


@pytest.mark.parametrize("coupling", YIELDS)
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
        assert np.abs(info["angle"] - info["target_angle"]).max() < YIELDS[coupling]


def test_the_first_half_second_decides_no_score():
    for name in ("none", "gravity"):
        arms = ArmVectorEnv(8, threads=1)
        traces = rollout(arms, make_policy(name, arms), range(8))
        rewards = np.sum([trace.rewards for trace in traces], axis=0)
        assert 0.03 < rewards[:50].sum() / rewards.sum() < 0.08
