import numpy as np
import pytest
from activesuit.envs.model import ArmConfig, bare_arm
from activesuit.envs.reference import follow, minimum_jerk, random_moves


def test_minimum_jerk_has_its_known_peaks():
    s = np.linspace(0, 1, 100_001)
    position, rate, acceleration = minimum_jerk(s)
    assert (position[0], position[-1]) == (0, 1)
    assert rate.max() == pytest.approx(1.875)
    assert acceleration.max() == pytest.approx(10 / np.sqrt(3))
    np.testing.assert_allclose(np.gradient(position, s)[1:-1], rate[1:-1], atol=1e-6)
    np.testing.assert_allclose(np.gradient(rate, s)[1:-1], acceleration[1:-1], atol=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_moves_stay_in_the_span_and_are_smooth(seed):
    dt = 0.01
    angle, rate, acceleration = random_moves(
        np.random.default_rng(seed), (0.5, 1.5), 1001, dt, (1.2, 2.4), (0.0, 0.5)
    )
    assert angle.min() >= 0.5
    assert angle.max() <= 1.5
    assert np.ptp(angle) > 0.25
    np.testing.assert_allclose(np.gradient(angle, dt), rate, atol=0.03)
    assert np.abs(np.diff(angle)).max() < 1.0 * 1.875 / 1.2 * dt * 1.01
    assert np.isfinite(acceleration).all()


def test_feedforward_of_a_still_arm_is_its_gravity_torque():
    angle = np.zeros((2, 4))
    angle[:, 1] = np.pi / 2
    still = follow(bare_arm(ArmConfig()), np.arange(4), (angle, np.zeros((2, 4)), np.zeros((2, 4))))
    np.testing.assert_allclose(still.feedforward[0, 1], 11.82, atol=0.006)
