import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis.loops import branches
from activesuit.hysteresis.smoothing import resample, smooth
from helpers import sweep
from scipy.ndimage import uniform_filter1d

TURNS = (0.52, 0.87, 0.52, 1.22, 0.52, 1.57, 0.52)
STEEP = 0.05  # [rad], constant with which a branch settles after a turn


def settling(angle):
    """Resistance that approaches 3 theta +- 2 exponentially after each reversal (Dahl's model)."""
    torque = np.zeros_like(angle)
    for i, step in enumerate(np.diff(angle), start=1):
        goal = 2 * np.sign(step)
        torque[i] = goal + (torque[i - 1] - goal) * np.exp(-abs(step) / STEEP)
    return torque + 3 * angle


def rms(x):
    return float(np.sqrt(np.mean(x**2)))


@pytest.mark.parametrize("seed", range(5))
def test_error_falls_and_the_tips_stay(seed):
    rng = np.random.default_rng(seed)
    angle = sweep(*TURNS, samples=400)
    truth = settling(angle)
    measured = truth + 0.1 * rng.standard_normal(angle.size)
    _, smoothed = smooth(angle, measured, bandwidth=0.06)
    # A moving average over as many samples rounds the tips.
    averaged = uniform_filter1d(measured, 51)
    tips = np.arange(1, 6) * 399
    assert rms(smoothed - truth) < 0.4 * rms(measured - truth)
    assert rms(smoothed - truth) < 0.5 * rms(averaged - truth)
    assert rms((smoothed - truth)[tips]) < 0.1
    assert rms((averaged - truth)[tips]) > 0.5


def test_the_tip_has_no_bias():
    rng = np.random.default_rng(0)
    angle = sweep(0.52, 1.57, 0.52, samples=200)
    truth = 8 * angle - np.where(np.arange(angle.size) < 200, 0, 12 * (1.57 - angle))
    tips = [
        smooth(angle, truth + 0.2 * rng.standard_normal(angle.size))[1][199] for _ in range(200)
    ]
    assert np.mean(tips) == pytest.approx(truth[199], abs=3 * np.std(tips) / np.sqrt(200))
    assert np.std(tips) < 0.1


@pytest.mark.parametrize("samples", [6, 40, 3000])
def test_parabolic_branches_pass_unchanged(samples):
    angle = sweep(0, 1, -0.5, 0.8, samples=samples)
    truth = np.concatenate(
        [2 * angle[:samples] ** 2, 2 - 3 * (1 - angle[samples : 2 * samples - 1])]
    )
    truth = np.concatenate([truth, -2.5 + (angle[2 * samples - 1 :] + 0.5) ** 2])
    smoothed_angle, smoothed = smooth(angle, truth)
    np.testing.assert_array_equal(smoothed_angle, angle)
    np.testing.assert_allclose(smoothed, truth, atol=1e-9)


def test_jitter_becomes_dwell_and_dwell_has_one_torque():
    rng = np.random.default_rng(3)
    rest = np.full(200, 1.0)
    motion = np.concatenate([np.linspace(0, 1, 300), rest, np.linspace(1, 0, 300)])
    pause = np.concatenate([motion[:100], np.full(50, motion[100]), motion[100:]])
    angle = pause + 0.001 * rng.standard_normal(pause.size)
    truth = settling(pause)
    torque = truth + 0.05 * rng.standard_normal(pause.size)
    new_angle, new_torque = smooth(angle, torque, bandwidth=0.05)
    (turn,) = np.flatnonzero(
        np.diff(np.sign(np.diff(new_angle[np.r_[True, np.diff(new_angle) != 0]])))
    )
    assert turn > 0  # exactly one reversal is left, at a dead band of zero
    assert rms(new_angle - pause) < 0.001
    assert rms(new_torque - truth) < 0.5 * rms(torque - truth)
    repeated = np.diff(new_angle) == 0
    assert repeated[110:140].any()
    np.testing.assert_array_equal(np.diff(new_torque)[repeated], 0)


@pytest.mark.parametrize("dwell", [0, 5, 500])
@pytest.mark.parametrize("step", [0.1, 1, 5])
def test_noise_does_not_exaggerate_the_turn(dwell, step):
    rng = np.random.default_rng(7)
    ramp = np.arange(-60, step / 2, step)
    motion = np.concatenate([ramp, np.zeros(dwell), ramp[-2::-1]])
    readings = motion + rng.standard_normal((40, motion.size))
    errors = [smooth(angle, motion)[0].max() for angle in readings]
    assert abs(np.mean(errors)) < 0.6
    assert abs(np.mean(errors)) <= abs(readings.max(axis=1).mean()) + 0.1


def test_branches_of_few_samples_and_a_single_branch():
    angle, torque = smooth([0, 1, 0, 1], [0, 5, 1, 6])
    np.testing.assert_array_equal(angle, [0, 1, 0, 1])
    np.testing.assert_array_equal(torque, [0, 5, 1, 6])
    angle = np.linspace(1, 0, 50)
    np.testing.assert_allclose(smooth(angle, 3 * angle)[1], 3 * angle, atol=1e-12)


def test_resample_is_monotone_and_exact_on_lines():
    angle = np.array([0, 0.1, 0.1, 0.45, 0.4, 1, 0.5, 0.0])
    rising, falling = branches(angle, 2 * angle, 0.2)
    grid, torque = resample(rising, 11)
    np.testing.assert_allclose(grid, np.linspace(0, 1, 11))
    np.testing.assert_allclose(torque, 2 * grid)
    grid, torque = resample(falling, 5)
    np.testing.assert_allclose(grid, [1, 0.75, 0.5, 0.25, 0])
    np.testing.assert_allclose(torque, 2 * grid)


def test_resample_takes_the_mean_of_a_dwell():
    (branch,) = branches([0, 1, 1, 2], [0, 1, 3, 2])
    np.testing.assert_allclose(resample(branch, 3)[1], [0, 2, 2])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: smooth([0, 1, 0], [0, 1, 0], bandwidth=0), "bandwidth is 0: give a finite number"),
        (lambda: smooth([0, 1, 0], [0, 1, 0], bandwidth=np.inf), "bandwidth is inf"),
        (lambda: smooth([0, 1, 0], [0, 1]), "angle has 3 samples and torque has 2"),
        (lambda: smooth([0, np.nan, 0], [0, 1, 0]), r"angle\[1\] is nan"),
        (lambda: smooth([2, 2, 2], [0, 1, 0]), "the angle stays within 0 rad"),
        (lambda: resample(branches([0, 1, 2], [0, 1, 2])[0], 1), "samples is 1: use at least 2"),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(InputError, match=message):
        call()
