"""Adaptive oscillators: they lock to rhythms, and assist nothing else."""

import numpy as np
import pytest
from activesuit.envs.policies import make_policy
from activesuit.envs.policies.oscillators import Oscillators
from activesuit.errors import InputError
from shown import asked, made

DT, SIZE = 0.01, 0.5
STARTS = np.array([0.0, 1.5, 3.0, 4.5])


def followed(frequency, cycles):
    """Returns oscillators after cycles of sines that begin anywhere, and the sines."""
    oscillators = Oscillators(2.0, DT)
    for period in range(round(cycles / frequency / DT)):
        turn = 2 * np.pi * frequency * DT * period + STARTS
        angle = 0.8 + SIZE * np.sin(turn)[:, None]
        if period == 0:
            oscillators.begin(angle)
        oscillators.step(angle)
    return oscillators, angle, 2 * np.pi * frequency * SIZE * np.cos(turn)[:, None]


@pytest.mark.parametrize("frequency", [0.3, 0.45, 0.7])
def test_they_lock_within_five_cycles(frequency):
    oscillators, angle, _ = followed(frequency, 5)
    np.testing.assert_allclose(oscillators.frequency, 2 * np.pi * frequency, rtol=0.05)
    np.testing.assert_allclose(oscillators.predicted()[0], angle, atol=0.05 * SIZE)


@pytest.mark.parametrize("frequency", [0.3, 0.45, 0.7])
def test_they_predict_angle_and_rate_in_the_end(frequency):
    oscillators, angle, rate = followed(frequency, 15)
    found_angle, found_rate = oscillators.predicted()
    np.testing.assert_allclose(found_angle, angle, atol=0.01 * SIZE)
    np.testing.assert_allclose(found_rate, rate, atol=0.03 * np.abs(rate).max())
    np.testing.assert_allclose(oscillators.confidence, 1)


def test_no_rhythm_gets_transparency_and_a_rhythm_compensation():
    policy, env = made("oscillators")
    transparent = make_policy("transparent", env)
    angle = np.array([0, 0.5, 1.0, 0])
    np.testing.assert_array_equal(
        asked(policy, env, angle=angle), asked(transparent, env, angle=angle)
    )
    compensation = make_policy("compensation", env)
    policy.reset()
    for period in range(2500):
        turn = 2 * np.pi * 0.4 * DT * period
        moved = np.array([0, 0.5, 0.5, 0])
        parts = {"angle": angle + moved * np.sin(turn), "rate": moved * 0.8 * np.pi * np.cos(turn)}
        found, whole = (asked(one, env, **parts) for one in (policy, compensation))
    np.testing.assert_allclose(found, whole, atol=0.5)


def test_options_out_of_range():
    _, env = made("oscillators")
    with pytest.raises(InputError, match=r"rate is 9.0: use a number from 0.1 to 4 1/s"):
        make_policy("oscillators:rate=9", env)
