"""The disturbance observer: what is not explained comes back through its filter."""

import math

import numpy as np
from activesuit.envs.policies import make_policy
from shown import asked, made


def step_response(bandwidth, time):
    pole = math.tau * bandwidth
    return 1 - (1 + pole * time) * math.exp(-pole * time)


def test_a_disturbance_is_cancelled_through_the_filter():
    bandwidth = 5.0
    # At rest, 2 and -1 N·m of the person without any motion: something withstands them.
    name = f"disturbance-observer:bandwidth={bandwidth}"
    policy, env = made(name, gravity="microgravity", suit="none")
    for period in range(1, 60):
        torque = asked(policy, env, interaction_torque=[0, 2, -1, 0])
        whole = step_response(bandwidth, 0.01 * period) * np.array([2, -1])
        np.testing.assert_allclose(torque, whole, rtol=1e-5)


def test_what_the_believed_arm_explains_is_no_disturbance():
    policy, env = made("disturbance-observer", gravity="earth")
    compensation = make_policy("compensation", env)
    peak = env.episodes.simulation.addresses.peak_torque
    angle = [0, 0.6, 1.0, 0]
    needed = asked(compensation, env, angle=angle)
    bare = needed - asked(make_policy("complement", env), env, angle=angle)
    for _ in range(50):  # motors carry all but the bare arm, which the person holds
        torque = asked(policy, env, angle=angle, motor_torque=(needed - bare) / peak)
    np.testing.assert_allclose(torque, needed, atol=1e-4)
