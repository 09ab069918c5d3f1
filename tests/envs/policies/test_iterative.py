"""Iterative learning contracts from cycle to cycle."""

import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.policies import make_policy, needed_options
from activesuit.envs.policies.iterative import learned

DT = 0.01


@pytest.mark.parametrize("gain", [0.3, 0.8])
def test_what_is_missing_contracts(gain):
    """A person who gives what the motors leave: the error shrinks by 1 - gain a cycle.

    It ends at what the filter takes from a cycle, a few hundredths of it.
    """
    phase = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    wanted = np.stack([3 * np.sin(phase), 2 + np.cos(phase)], axis=-1)[:, None]
    known, errors = np.zeros_like(wanted), []
    for _ in range(8):
        missing = wanted - known
        errors.append(np.abs(missing).max())
        known = learned(known, missing, gain, ahead=0, dt=DT)
    # What the filter takes from a cycle stays missing, the more the smaller the gain.
    left = [errors[0] * (1 - gain) ** cycle for cycle in range(8)]
    np.testing.assert_allclose(errors, left, atol=0.02 * errors[0])
    for _ in range(20):
        known = learned(known, wanted - known, gain, ahead=0, dt=DT)
    assert np.abs(wanted - known).max() < 0.04 * np.abs(wanted).max()


def test_it_comes_earlier_by_the_lag_of_the_motors():
    missing = np.zeros((100, 1, 2))
    missing[50] = 1.0
    found = learned(np.zeros_like(missing), missing, 1.0, ahead=3, dt=DT)
    assert found[:, 0, 0].argmax() == 47


def test_it_helps_from_cycle_to_cycle():
    """In the ratchet the wearer gives less in the last cycles than under compensation."""
    given = {}
    for name in ("compensation", "iterative"):
        env = ArmEnv("Ratchet", **needed_options(name))
        policy = make_policy(name, env)
        observation, info = env.reset(seed=0)
        policy.reset()
        torques = []
        for _ in range(800):
            observation, *_, info = env.step(policy.act(observation))
            torques.append(info["human_torque"][2])
        given[name] = np.sqrt(np.mean(np.square(torques[600:])))
    assert given["iterative"] < 0.8 * given["compensation"]


def test_without_a_cycle_it_is_compensation():
    env = ArmEnv(**needed_options("iterative"))
    observation, _ = env.reset(seed=0)
    policies = [make_policy(name, env) for name in ("compensation", "iterative")]
    for _ in range(20):
        first, second = (policy.act(observation) for policy in policies)
        np.testing.assert_array_equal(first, second)
        observation, *_ = env.step(first)
