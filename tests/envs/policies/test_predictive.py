"""Predictive sampling."""

import numpy as np
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import rollout
from activesuit.envs.policies import make_policy


def effort(traces):
    return np.sqrt(np.mean([trace.effort**2 for trace in traces]))


def test_it_is_no_worse_than_compensation():
    arms = ArmEnv("ElbowFlexion", gravity="microgravity").rows(2, max_episode_steps=300)
    plain = rollout(arms, make_policy("compensation", arms), [1, 2])
    policy = make_policy("predictive:samples=8", arms)
    first, again = rollout(arms, policy, [1, 2]), rollout(arms, policy, [1, 2])
    assert effort(first) < 1.1 * effort(plain)
    assert effort(first) != effort(plain)
    for one, other in zip(first, again, strict=True):  # its samples have a seed
        np.testing.assert_array_equal(one.human_torque, other.human_torque)


def test_it_plans_on_what_it_believes():
    arms = ArmEnv("ElbowFlexion", suit="emu-like", gravity="microgravity").rows(
        1, max_episode_steps=200
    )
    right = rollout(arms, make_policy("predictive:samples=4", arms), [1])
    wrong = rollout(arms, make_policy("predictive:samples=4,suit=mock-suit", arms), [1])
    assert effort(right) < 0.8 * effort(wrong)
