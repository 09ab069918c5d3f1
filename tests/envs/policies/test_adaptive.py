"""Adaptive compensation against its textbook properties."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs import TASKS, ArmEnv
from activesuit.envs.evaluation import rollout
from activesuit.envs.policies import make_policy, needed_options
from activesuit.envs.policies.adaptive import SCALES


@pytest.mark.parametrize("factor", [0.7, pytest.param(1.4, marks=pytest.mark.slow)])
def test_it_recovers_a_scaled_suit(factor):
    """Within 10 % in 30 s of motion, by what it says the suit needs along that motion."""
    suit = load_suit("emu-like")
    joints = {name: entry.scaled(torque=factor) for name, entry in suit.joints.items()}
    task = replace(TASKS["MinorLoops"], duration=30.0)
    options = {"suit": suit.model_copy(update={"joints": joints}), "gravity": "microgravity"}
    arms = ArmEnv(task, **options, **needed_options("adaptive")).rows(2, max_episode_steps=3000)
    policy = make_policy("adaptive:suit=emu-like", arms)
    rollout(arms, policy, [1, 2])
    scale = policy.estimate[..., 0]
    np.testing.assert_allclose(scale, factor, rtol=0.1)


def test_the_right_belief_stays():
    options = {"gravity": "microgravity", **needed_options("adaptive")}
    arms = ArmEnv("ElbowFlexion", **options).rows(2, max_episode_steps=1000)
    policy = make_policy("adaptive", arms)
    rollout(arms, policy, [1, 2])
    np.testing.assert_allclose(policy.estimate[:, 1, 0], 1.0, atol=0.15)


def test_no_data_leave_the_certified_set():
    """Whatever is measured, the corrected suit is a certified one."""
    arms = ArmEnv(**needed_options("adaptive")).rows(3)
    policy = make_policy("adaptive", arms)
    still = {"motor_torque": np.zeros((3, 2)), "interaction_torque": np.zeros((3, 4))}
    policy.begin({"angle": np.zeros((3, 4)), "rate": np.zeros((3, 4)), **still})
    rng = np.random.default_rng(0)
    entry = load_suit("mock-suit").joints["elbow_flexion"]
    for i in range(2000):
        terms = rng.standard_cauchy((3, 2, 4)) * 10.0 ** rng.integers(-3, 3)
        measured = rng.choice([np.nan, np.inf, 0.0, 1.0], (3, 2), p=[0.02, 0.02, 0.06, 0.9])
        policy.learn(terms, measured * rng.standard_cauchy((3, 2)) * 100, rng.random((3, 2)) < 0.9)
        assert np.isfinite(policy.estimate).all()
        scale = policy.estimate[..., 0]
        assert scale.min() >= SCALES[0] and scale.max() <= SCALES[1]
        if i % 500 == 0:
            model = entry.model.scaled(torque=float(scale[0, 1]))
            assert model.certificate(entry.range).certified
