"""Noise that is white, slow, or both: whitening, and its estimate from a residual."""

import numpy as np
import pytest
from activesuit.identification.residual.noise import (
    GRID,
    Noise,
    estimate_noise,
    independent,
    slow_noise,
    whiten,
)
from scipy.linalg import toeplitz

SIZES = [70, 50]


@pytest.mark.parametrize(("memory", "white"), [(0.0, 0.0), (0.9, 0.0), (0.95, 0.5)])
def test_whitening_is_the_inverse_of_a_cholesky_factor(memory, white):
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


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_a_residual_identifies_its_noise(memory):
    sizes, found = [200, 200, 200], []
    columns = np.vander(np.linspace(-1, 1, 600), 6)
    for seed in range(10):
        rng = np.random.default_rng(seed)
        noise = np.concatenate([0.3 * slow_noise(size, memory, rng) for size in sizes])
        left = noise - columns @ np.linalg.lstsq(columns, noise, rcond=None)[0]
        found.append(estimate_noise(columns, left, sizes))
    assert np.mean([one.deviation for one in found]) == pytest.approx(0.3, rel=0.12)
    assert np.mean([one.memory for one in found]) == pytest.approx(memory, abs=0.06)
    assert (np.mean([one.white for one in found]) > 0.5) == (memory == 0)
    assert found[0].freedom == 594
    assert found[0].weight.sum() == pytest.approx(1)


def test_slow_noise_has_its_correlation_from_the_first_sample_on():
    rng = np.random.default_rng(0)
    many = np.array([slow_noise(3, 0.8, rng) for _ in range(20_000)])
    np.testing.assert_allclose(many.std(axis=0), 1, rtol=0.03)
    np.testing.assert_allclose(np.corrcoef(many.T)[0], [1, 0.8, 0.64], atol=0.02)


def test_drawn_noise_is_of_the_grid():
    weight = np.zeros(len(GRID))
    weight[30] = 1.0
    noise = Noise(weight=weight, variance=np.full(len(GRID), 0.04), freedom=100)
    drawn = noise.draw([5000, 5000], np.random.default_rng(0))
    memory, white = GRID[30]
    assert drawn.std() == pytest.approx(0.2, rel=0.1)
    assert np.corrcoef(drawn[:-1], drawn[1:])[0, 1] == pytest.approx((1 - white) * memory, abs=0.05)


def test_columns_that_depend_on_others_count_once():
    one, two = np.random.default_rng(0).standard_normal((2, 40))
    basis = independent(np.column_stack([one, two, one + 2 * two, np.zeros(40)]))
    assert basis.shape == (40, 2)
    np.testing.assert_allclose(basis.T @ basis, np.eye(2), atol=1e-12)
    assert independent(np.zeros((40, 2))).shape == (40, 0)
