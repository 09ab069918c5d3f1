"""The radial basis tracker: its network, what it learns, and its bounds."""

import numpy as np
import pytest
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy
from activesuit.errors import InputError
from shown import asked, made


def test_activities_add_up_to_one():
    policy, _ = made("radial-basis")
    angle = np.random.default_rng(0).uniform(-1, 2, (5, 2))
    active = policy.activity(angle, 3 * angle)
    np.testing.assert_allclose(active.sum(1), 1)
    assert (active >= 0).all()


def test_it_learns_a_constant_load():
    policy, env = made("radial-basis")
    inertia, load = Plant.of(env.episodes).believed().inertia().nominal(), np.array([8.0, 3.0])
    angle, rate, target, errors = np.zeros(2), np.zeros(2), np.array([0.6, 0.6]), []
    angle += target
    for _ in range(1500):
        parts = {"angle": [0, *angle, 0], "rate": [0, *rate, 0], "target": np.tile(target, 3)}
        torque = asked(policy, env, **parts)
        rate = rate + 0.01 * (torque - load) / inertia
        angle = angle + 0.01 * rate
        errors.append(np.abs(target - angle))
    errors = np.array(errors)
    assert (errors[-1] < 0.1 * errors.max(axis=0)).all()
    np.testing.assert_allclose(torque, load, rtol=0.1)


def test_what_it_learns_is_bounded_by_the_peak():
    policy, env = made("radial-basis")
    peak = env.episodes.simulation.addresses.peak_torque
    for _ in range(3000):
        asked(policy, env, target=[0.4, 0.4] * 3)
    rest = asked(policy, env)  # no error: what is left is what has been learned, nearby
    assert (rest <= peak).all()
    assert (rest > 0.3 * peak).all()


def test_options_out_of_range():
    _, env = made("radial-basis")
    with pytest.raises(InputError, match=r"bandwidth is 9.0: use a number from 0.1 to 3 Hz"):
        make_policy("radial-basis:bandwidth=9", env)
