"""Intended motions, and the torque that moves a bare arm along them."""

import mujoco
import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, bare_arm
from activesuit.envs.simulation.inverse_dynamics import Chain, arm_torques
from activesuit.envs.tasks.motions import minimum_jerk, random_moves


def test_minimum_jerk_has_its_known_peaks():
    s = np.linspace(0, 1, 100_001)
    position, rate, acceleration = minimum_jerk(s)
    assert (position[0], position[-1]) == (0, 1)
    assert rate.max() == pytest.approx(1.875)
    assert acceleration.max() == pytest.approx(10 / np.sqrt(3))
    np.testing.assert_allclose(np.gradient(position, s)[1:-1], rate[1:-1], atol=1e-6)
    np.testing.assert_allclose(np.gradient(rate, s)[1:-1], acceleration[1:-1], atol=1e-4)


@pytest.mark.parametrize("seed", range(2))
def test_moves_stay_in_the_span_and_are_smooth(seed):
    dt = 0.01
    angle, rate, acceleration = random_moves(
        np.random.default_rng(seed), 0.5, 1.5, 1001, dt, (1.2, 2.4), (0.0, 0.5)
    )
    assert 0.5 <= angle.min() < angle.max() - 0.25 and angle.max() <= 1.5
    np.testing.assert_allclose(np.gradient(angle, dt), rate, atol=0.03)
    assert np.abs(np.diff(angle)).max() < 1.0 * 1.875 / 1.2 * dt * 1.01
    assert np.isfinite(acceleration).all()


@pytest.mark.parametrize(
    "options",
    [
        {"side": "left", "tilt": (0.4, -0.3)},
        {"wearer": {"sex": "female", "stature": 1.5, "mass": 48.0}, "gravity": "moon"},
    ],
)
def test_the_kernel_agrees_with_mujoco(options):
    arm = bare_arm(ArmConfig(**options))
    rng, data = np.random.default_rng(0), mujoco.MjData(arm)
    low, high = arm.jnt_range.T
    angle = rng.uniform(low + 0.01, high - 0.01, (200, 4))
    rate, acceleration = rng.uniform(-6, 6, (200, 4)), rng.uniform(-60, 60, (200, 4))
    expected = np.empty((200, 4))
    for i in range(200):
        data.qpos[:], data.qvel[:], data.qacc[:] = angle[i], rate[i], acceleration[i]
        mujoco.mj_inverse(arm, data)
        expected[i] = data.qfrc_inverse
    found = arm_torques(Chain.of(arm), angle, rate, acceleration)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-11)
    assert np.abs(expected).max() > 5
