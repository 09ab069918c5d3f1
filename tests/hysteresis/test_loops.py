from itertools import pairwise

import numpy as np
import pytest
from activesuit.hysteresis.loops import branches, estimate_dead_band, reversals
from helpers import assert_refused, sweep
from hypothesis import given, settings
from hypothesis import strategies as st

FAMILY = (0.35, 0.52, 0.35, 0.70, 0.35, 0.87, 0.35)  # Li et al. 2022, shoulder


def with_dwell(turns, samples, dwell):
    """Motion through `turns` that rests at each of them."""
    pieces = [np.linspace(a, b, samples) for a, b in pairwise(turns)]
    rests = [np.full(dwell, b) for _, b in pairwise(turns)]
    return np.concatenate([x for pair in zip(pieces, rests, strict=True) for x in pair])


@st.composite
def noisy_motions(draw):
    """Turns, a motion through them with dwell, the dead band, and noise of less than half of it."""
    dead_band = 10 ** draw(st.floats(-4, 0))
    swings = draw(st.lists(st.floats(2.01, 30), min_size=1, max_size=8))
    sign = draw(st.sampled_from([-1, 1]))
    steps = [sign * (-1) ** i * swing * dead_band for i, swing in enumerate(swings)]
    turns = np.concatenate([[0.3], 0.3 + np.cumsum(steps)])
    motion = with_dwell(turns, draw(st.integers(3, 40)), draw(st.integers(0, 10)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    noise = draw(st.sampled_from([0, 0.1, 0.49])) * dead_band
    return turns, motion, dead_band, rng.uniform(-noise, noise, motion.size)


@settings(max_examples=300, deadline=None)
@given(noisy_motions())
def test_noise_below_half_the_dead_band_neither_adds_nor_hides_a_reversal(motions):
    turns, motion, dead_band, noise = motions
    pieces = branches(motion + noise, motion, dead_band)
    assert [piece.direction for piece in pieces] == np.sign(np.diff(turns)).tolist()
    found = reversals(motion + noise, dead_band)
    bound = 2 * np.abs(noise).max() + 1e-12
    np.testing.assert_allclose(motion[found], turns[1:-1], atol=bound)
    # The branches cover the record and share the sample at each turn.
    assert [piece.start for piece in pieces] == [0, *found]
    assert [piece.stop - 1 for piece in pieces] == [*found, motion.size - 1]
    for piece in pieces:
        np.testing.assert_array_equal(piece.angle, (motion + noise)[piece.start : piece.stop])
        np.testing.assert_array_equal(piece.torque, motion[piece.start : piece.stop])


def test_default_dead_band_survives_gaussian_noise_and_long_dwell():
    for seed in range(10):
        motion = with_dwell(FAMILY, 150, 300)
        angle = motion + 0.002 * np.random.default_rng(seed).standard_normal(motion.size)
        assert estimate_dead_band(angle) == pytest.approx(0.02, rel=0.15)
        assert len(branches(angle, motion)) == 6


def test_default_dead_band_of_a_coarse_sensor_that_flickers():
    rng = np.random.default_rng(0)
    motion = with_dwell(FAMILY, 1000, 300)
    angle = 0.005 * np.round((motion + 1e-4 * rng.standard_normal(motion.size)) / 0.005)
    angle += 0.005 * (rng.random(motion.size) < 0.01)
    assert len(branches(angle, motion)) == 6


def test_clean_records_need_no_dead_band():
    for angle, turns in [
        ([0, 1, 0], [1]),
        ([-1, 1, -1, 1, -1], [1, 2, 3]),
        ([0, 1, 2, 3, 2, 1, 0], [3]),
        ([0, 1, 2, 3, 3, 3, 2, 1, 0], [3]),
        (np.sin(np.linspace(0, 4 * np.pi, 33)), [4, 12, 20, 28]),
        (sweep(*FAMILY, samples=8), [7, 14, 21, 28, 35]),
    ]:
        assert reversals(angle).tolist() == turns


def test_a_motion_without_noise_turns_even_at_a_dead_band_of_zero():
    assert reversals([0, 1, 1, 0.999, 2], 0).tolist() == [1, 3]
    assert reversals([1, 1, 1]).size == 0


up = [0.0, 0.5, 1.0]


def test_bad_input():
    rows = [
        (lambda: branches([0, np.nan, 1], up), r"angle\[1\] is nan: give finite numbers \(rad\)"),
        (lambda: branches(up, [0, 1, np.inf]), r"torque\[2\] is inf: give finite numbers \(N·m\)"),
        (lambda: branches([up, up], up), r"angle has shape \(2, 3\)"),
        (lambda: branches(up, [0, 1]), "angle has 3 samples and torque has 2"),
        (lambda: branches([0, 1], [0, 1]), "the record has 2 samples: a reversal takes at least 3"),
        (lambda: branches([1, 1, 1], up), "the angle stays within 0 rad"),
        (lambda: branches(up, up, 2), "stays within 1 rad and the dead band is 2 rad"),
        (lambda: reversals(up, -1), "dead_band is -1: give a finite number, at least 0"),
        (lambda: reversals(up, np.nan), "dead_band is nan"),
        (lambda: reversals([0, -1e200, 0]), r"angle\[1\] is -1e\+200: give numbers of at most 1e"),
        (lambda: reversals([]), r"angle has shape \(0,\)"),
    ]
    assert_refused(lambda call: call(), rows)
