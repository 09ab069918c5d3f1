"""What counts as an oscillation, and what does not."""

import numpy as np
import pytest
from activesuit.envs.evaluation.reasons import oscillation
from scipy.signal import lfilter

DT = 0.01
TIME = np.arange(1, 6001) * DT
NOISES = 60  # of each kind


def moves(time, hold=6.0, move=1.5):
    """Places that are held, with smooth moves between them, as in OverheadHold."""
    stops = np.arange(0.0, time[-1] + 2 * (hold + move), hold + move)
    places = np.random.default_rng(3).uniform(0.8, 1.2, len(stops))
    phase = np.clip(((time % (hold + move)) - hold) / move, 0, 1)
    smooth = phase**3 * (10 - 15 * phase + 6 * phase**2)
    at = (time // (hold + move)).astype(int)
    return (places[at] + (places[at + 1] - places[at]) * smooth)[:, None]


def cycles(time, period=4.0):
    return 0.4 * np.sin(2 * np.pi * time / period)[:, None]


def rest(time):
    return np.full((len(time), 4), 0.7)


@pytest.mark.parametrize(
    ("intended", "period", "amplitude"),
    [(moves, 2.5, 0.035), (cycles, 0.31, 0.2), (rest, 6.5, 0.05), (moves, 6.5, 0.05)],
)
def test_a_sine_has_its_period_and_amplitude(intended, period, amplitude):
    error = amplitude * np.sin(2 * np.pi * TIME / period + 0.4) + amplitude * (TIME / 60 - 0.3)
    found = oscillation(error, intended(TIME), DT)
    assert found is not None and found.period_s == pytest.approx(period, rel=0.03)
    assert found.amplitude == pytest.approx(amplitude, rel=0.05)
    assert oscillation(error + 2 * amplitude, intended(TIME), DT) is None  # most of it is constant


def test_a_cycle_that_begins_anew_at_each_place():
    """Its phase begins anew with each move, and it is no sine."""
    since = TIME % 7.5
    swing = np.tanh(3 * np.sin(2 * np.pi * since / 2.4)) * (since < 6.0)
    noise = np.random.default_rng(0).normal(scale=0.1, size=len(TIME))
    found = oscillation(0.05 * (swing + noise), moves(TIME), DT)
    assert found is not None and found.period_s == pytest.approx(2.4, rel=0.02)


@pytest.mark.parametrize("seconds", [0.5, 24, pytest.param(120, marks=pytest.mark.slow)])
def test_noise_and_drift_do_not_oscillate(seconds):
    random, n = np.random.default_rng(5), round(seconds / DT)
    time = np.arange(1, n + 1) * DT
    for _ in range(NOISES if seconds < 100 else NOISES // 3):
        white = random.normal(size=n)
        share = np.exp(-DT / random.uniform(0.02, 3.0))
        slow = lfilter([1], [1, -share], white)
        errors = [white, slow, lfilter([1], [1, -share], slow), np.cumsum(white), np.cumsum(slow)]
        errors += [np.zeros(n), time, np.exp(-time / random.uniform(0.1, 30)), white + 9 * time]
        intended = moves(time) if random.random() < 0.5 else np.cumsum(slow)[:, None] * 1e-4
        for error in errors:
            assert oscillation(error, intended, DT) is None


@pytest.mark.parametrize("period", [1.0, 7.0])
def test_what_the_intended_motion_causes_is_no_oscillation(period):
    """Lag, spring, inertia and friction about a cyclic motion that grows."""
    growing = cycles(TIME, period)[:, 0] * (0.3 + TIME / TIME[-1])
    intended = np.stack([growing, np.full_like(growing, 0.5)], axis=1)
    rate = np.gradient(growing, DT)
    lag = np.interp(TIME - 0.15, TIME, growing) - growing
    random = np.random.default_rng(1).normal(scale=0.02, size=len(TIME))
    for error in (lag, 0.1 * growing, 0.05 * np.sign(rate), lag + 0.05 * np.sign(rate) + random):
        assert oscillation(error, intended, DT) is None
    swing = 0.5 * np.sin(2 * np.pi * TIME / 1.3)
    found = oscillation(lag + swing, intended, DT)
    assert found is not None and found.period_s == pytest.approx(1.3, rel=0.02)


@pytest.mark.parametrize("signs", [(1, 1), (1, -0.3)])
def test_what_follows_each_move_is_no_oscillation(signs):
    since = (TIME - 6.0) % 7.5
    shape = np.exp(-since / 1.5) - 1.3 * np.exp(-since / 0.5)
    error = shape * np.where((TIME - 6.0) // 7.5 % 2, *signs)
    assert oscillation(error, moves(TIME), DT) is None


def test_too_few_samples():
    for n in (0, 1, 2, 14):
        assert oscillation(np.ones(n), np.ones((n, 4)), DT) is None
