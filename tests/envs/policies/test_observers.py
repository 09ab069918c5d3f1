"""Controllers that find what acts on the arm: observers of momentum and of disturbances."""

import math

import mujoco
import numpy as np
import pytest
from activesuit.envs import ArmEnv
from activesuit.envs.evaluation import evaluate
from activesuit.envs.plant import Plant
from activesuit.envs.policies import make_policy
from activesuit.envs.policies.observers import MomentumObserver
from shown import asked, made


@pytest.mark.parametrize("bandwidth", [2.0, 30.0])
def test_the_residual_of_a_step_is_exponential(bandwidth):
    observer, unknown = MomentumObserver(bandwidth, 0.01), np.array([[3.0, -1.0]])
    observer.begin(np.zeros((1, 2)))
    for period in range(1, 100):
        momentum = (unknown + 0.5) * 0.01 * period
        residual = observer.step(momentum, np.full((1, 2), 0.5))
        grown = 1 - math.exp(-bandwidth * 0.01 * period)
        np.testing.assert_allclose(residual, grown * unknown, rtol=1e-9)


def test_the_momentum_observer_finds_a_torque_on_a_moving_arm():
    # The believed arm swings from rest under gravity, with an unknown constant torque.
    arm, unknown = Plant.of(ArmEnv(suit="none").episodes).believed(), np.array([4.0, -1.5])
    inertia, weight, model = arm.inertia(), arm.whole_weight(), arm.model()
    model.dof_frictionloss[:] = 0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    data = mujoco.MjData(model)
    data.qpos[:], data.qfrc_applied[1:3] = [0.1, 0.9, 1.2, 0.1], unknown
    observer = MomentumObserver(10.0, 0.01)
    observer.begin(inertia.momentum(data.qpos[None], data.qvel[None])[0])
    for period in range(1, 61):
        known = np.zeros((1, 2))
        for _ in range(10):
            mujoco.mj_forward(model, data)
            other = (data.qfrc_passive + data.qfrc_constraint)[None, 1:3]
            gyration = inertia.momentum(data.qpos[None], data.qvel[None])[1]
            known += (gyration - weight(data.qpos[None]) + other) / 10
            data.qvel[:] += 0.001 * data.qacc
            data.qpos[:] += 0.001 * data.qvel
        momentum = inertia.momentum(data.qpos[None], data.qvel[None])[0]
        grown = 1 - math.exp(-0.1 * period)
        found = observer.step(momentum, known)[0]
        np.testing.assert_allclose(found, grown * unknown, atol=0.03 * np.abs(unknown).max())
    assert np.abs(data.qvel).max() > 1  # it has moved fast meanwhile


def test_the_momentum_observer_needs_no_model_of_the_suit():
    options = {"motions": 1, "adapted": False, "references": False}
    options |= {"gravity": "microgravity", "suit": "emu-like"}
    policies = ("none", "observer", "compensation:suit=mock-suit")
    scores = evaluate("ActiveSuit/ElbowFlexion-v0", policies, **options).scores
    off, observer, compensation = (scores[name].torque["elbow_flexion"][0] for name in policies)
    assert observer < 0.3 * off and observer < 0.5 * compensation


def test_a_disturbance_is_cancelled_through_the_filter():
    bandwidth = 5.0
    # At rest, 2 and -1 N·m of the person without any motion: something withstands them.
    name = f"disturbance-observer:bandwidth={bandwidth}"
    policy, env = made(name, gravity="microgravity", suit="none")
    for period in range(1, 60):
        torque = asked(policy, env, interaction_torque=[0, 2, -1, 0])
        phase = math.tau * bandwidth * 0.01 * period
        whole = (1 - (1 + phase) * math.exp(-phase)) * np.array([2, -1])
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
