"""The derivatives of the Jiles-Atherton torque, against a complex step through eq. (4) itself."""

from types import SimpleNamespace

import numpy as np
import pytest
from activesuit.benchmarks.references.models import JilesAthertonReference
from activesuit.hysteresis.jiles_atherton import PARAMETERS
from activesuit.hysteresis.jiles_atherton.kernels import (
    population_response,
    response_and_derivatives,
)
from helpers import TABLE_2, sweep

TINY = 1e-30


def with_derivatives(angle, row, initial=0.0):
    torque, derivatives = np.empty(angle.size), np.empty((angle.size, 6))
    starts = np.array([0, angle.size])
    response_and_derivatives(angle, starts, np.array([initial]), row, torque, derivatives)
    return torque, derivatives


def slow_response(angle, *numbers):
    """The readable model at angles in degrees, for complex parameters and a complex start too."""
    *row, initial = numbers
    model = SimpleNamespace(**dict(zip(PARAMETERS, row, strict=True)), angle_unit="deg")
    reference = JilesAthertonReference(model, np.radians(angle), 0.0)
    reference.torque = initial
    return np.array([initial, *map(reference.move, np.radians(angle[1:]))])


@pytest.mark.parametrize("name", TABLE_2)
def test_derivatives_are_those_of_eq_4(name):
    angle = np.degrees(sweep(0.35, 1.2, 0.6, 1.0, 0.35, samples=6))
    row, initial = np.array(TABLE_2[name]), -0.7
    torque, derivatives = with_derivatives(angle, row, initial)
    at = np.append(row, initial).astype(complex)
    np.testing.assert_allclose(torque, slow_response(angle, *at).real, atol=1e-6)
    for i in range(6):
        moved = at.copy()
        moved[i] += TINY * 1j
        expected = slow_response(angle, *moved).imag / TINY
        scale = np.abs(expected).max()
        np.testing.assert_allclose(derivatives[:, i], expected, atol=1e-6 * scale)


def test_torque_is_that_of_the_population_to_the_last_bit():
    rng = np.random.default_rng(0)
    angle = np.concatenate([np.degrees(sweep(0.3, top, 0.5, samples=40)) for top in (0.9, 1.5)])
    angle[10:12] = angle[9]
    starts, initial = np.array([0, angle.size // 2, angle.size]), np.array([0.0, 0.4])
    low, high = [1, 0.5, -10, 0.5, 0], [100, 3.5, 10, 10, 3]
    rows = rng.uniform(low, high, (200, 5))
    rows[:, [1, 4]] = 10 ** rows[:, [1, 4]]
    expected = np.empty((200, angle.size))
    population_response(angle, starts, np.tile(initial, (200, 1)), rows, expected)
    assert 20 < np.isnan(expected).any(axis=1).sum() < 180  # some meet their pole, some do not
    for row, of_population in zip(rows, expected, strict=True):
        torque, derivatives = np.empty(angle.size), np.empty((angle.size, 6))
        response_and_derivatives(angle, starts, initial, row, torque, derivatives)
        np.testing.assert_array_equal(torque, of_population)
        assert np.isfinite(derivatives[np.isfinite(torque)]).all()


def test_torque_scales_with_Ms():
    # M is linear in Ms at fixed alpha Ms and M0 / Ms: Ms dM/dMs - alpha dM/dalpha + M0 dM/dM0 = M.
    angle = np.degrees(sweep(0.2, 1.4, 0.3, 1.1, samples=30))
    for row in TABLE_2.values():
        torque, derivatives = with_derivatives(angle, np.array(row), 0.5)
        Ms, _, alpha, _, _ = row
        found = Ms * derivatives[:, 0] - alpha * derivatives[:, 2] + 0.5 * derivatives[:, 5]
        np.testing.assert_allclose(found, torque, atol=1e-6 * np.abs(torque).max())
