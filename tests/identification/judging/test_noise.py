"""Noise that is white, slow, or both: whitening, and its estimate from a residual."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.identification.fits.tangent import independent
from activesuit.identification.judging.noise import (
    EVEN,
    GRID,
    Noise,
    Uneven,
    estimate_noise,
    slow_noise,
    uneven_noise,
    whiten,
)
from scipy.linalg import toeplitz

SIZES = [70, 50]


def test_whitening_is_the_inverse_of_a_cholesky_factor():
    for memory, white in [(0.0, 0.0), (0.9, 0.0), (0.95, 0.5)]:
        values = np.random.default_rng(0).standard_normal((sum(SIZES), 3))
        found, log_det = whiten(values, SIZES, memory, white)
        parts, logs = [], 0.0
        for part in np.split(values, [SIZES[0]]):
            n = len(part)
            slow = toeplitz(memory ** np.arange(n)) if memory else np.eye(n)
            factor = np.linalg.cholesky((1 - white) * slow + white * np.eye(n))
            parts.append(np.linalg.solve(factor, part))
            logs += np.log(np.diag(factor)).sum()
        np.testing.assert_allclose(found, np.vstack(parts), atol=1e-9)
        assert log_det == pytest.approx(logs, abs=1e-9)


def test_a_residual_identifies_its_noise():
    for memory in [0.0, 0.5, 0.9]:
        sizes, found = [200, 200, 200], []
        columns = np.vander(np.linspace(-1, 1, 600), 6)
        for seed in range(10):
            rng = np.random.default_rng(seed)
            noise = np.concatenate([0.3 * slow_noise(size, memory, rng) for size in sizes])
            left = noise - columns @ np.linalg.lstsq(columns, noise, rcond=None)[0]
            found.append(estimate_noise(columns, left, sizes))
        assert np.mean([one.deviation for one in found]) == pytest.approx(0.3, rel=0.12)
        assert np.mean([one.memory for one in found]) == pytest.approx(memory, abs=0.06)
        assert (np.mean([one.weight[0] for one in found]) > 0.5) == (memory == 0)
        assert found[0].freedom == 594
        assert found[0].weight.sum() == pytest.approx(1)


def test_slow_noise_has_its_correlation_from_the_first_sample_on():
    rng = np.random.default_rng(0)
    many = np.array([slow_noise(3, 0.8, rng) for _ in range(20_000)])
    np.testing.assert_allclose(many.std(axis=0), 1, rtol=0.03)
    np.testing.assert_allclose(np.corrcoef(many.T)[0], [1, 0.8, 0.64], atol=0.02)


def test_columns_that_depend_on_others_count_once():
    one, two = np.random.default_rng(0).standard_normal((2, 40))
    basis = independent(np.column_stack([one, two, one + 2 * two, np.zeros(40)]))
    assert basis.shape == (40, 2)
    np.testing.assert_allclose(basis.T @ basis, np.eye(2), atol=1e-12)
    assert independent(np.zeros((40, 2))).shape == (40, 0)


def test_noise_in_proportion_to_the_torque_is_distinguished_from_even_noise():
    rng = np.random.default_rng(3)
    torque = np.tile(np.concatenate([np.linspace(0, 10, 120), np.linspace(10, -1, 120)]), 3)
    sizes, shares = [240] * 3, []
    for _ in range(8):
        even = 0.1 * rng.standard_normal(torque.size)
        assert uneven_noise(even, torque, sizes) == EVEN
        assert uneven_noise(0.1 * rng.standard_t(3, torque.size), torque, sizes) == EVEN
        drawn = np.hypot(0.02, 0.015 * torque) * rng.standard_normal(torque.size)
        uneven = uneven_noise(drawn, torque, sizes)
        scale = uneven.at(torque)
        assert np.mean(scale**2) == pytest.approx(1)
        shares.append(estimate_noise(np.empty((720, 0)), drawn / scale, sizes, uneven).share)
    assert np.mean(shares) == pytest.approx(0.015, rel=0.1)
    assert uneven_noise(np.zeros(720), torque, sizes) == EVEN


def test_noise_is_drawn_with_its_deviation_and_correlation():
    weights, rng = np.eye(len(GRID)), np.random.default_rng(0)
    noise = Noise(weights[0], np.full(len(GRID), 4e-4), 100)
    uneven = replace(noise, uneven=Uneven(ratio=0.75, square=1.0))
    assert (uneven.constant, uneven.share) == pytest.approx((0.02, 0.015))
    drawn = uneven.draw(np.full(9000, 4.0), [9000], rng)
    assert np.std(drawn) == pytest.approx(0.02 * np.hypot(1, 3), rel=0.05)
    drawn = replace(noise, weight=weights[30]).draw(np.ones(10_000), [5000, 5000], rng)
    memory, white = GRID[30]
    assert drawn.std() == pytest.approx(0.02, rel=0.1)
    assert np.corrcoef(drawn[:-1], drawn[1:])[0, 1] == pytest.approx((1 - white) * memory, abs=0.05)
