"""Many models at once against the models one by one; derivatives against a complex step."""

from types import SimpleNamespace

import numpy as np
import pytest
from activesuit.benchmarks.references.models import JilesAthertonReference
from activesuit.hysteresis.jiles_atherton import PARAMETERS, kernels
from activesuit.hysteresis.protocol import responder
from helpers import TABLE_2, sweep

LOW, HIGH = np.array([[1, 100], [3, 5000], [-10, 10], [-10, 10], [1, 1000]], dtype=float).T


def together(angle, starts, initial, parameters):
    torque = np.full((len(parameters), angle.size), np.inf)
    each = np.tile(initial, (len(parameters), 1))
    kernels.population_response(angle, starts, each, parameters, torque)
    return torque


def one_by_one(angle, starts, initial, parameters):
    torque = np.full((len(parameters), angle.size), np.inf)
    p, s = np.zeros(kernels.PARAMETER_SIZE), np.zeros(kernels.MEMORY_SIZE)
    for row, numbers in zip(torque, parameters, strict=True):
        kernels.set_parameters(p, *numbers, 0, 0)
        for start, end, torque0 in zip(starts[:-1], starts[1:], initial, strict=True):
            kernels.begin(p, s, angle[start], torque0)
            responder(kernels)(p, s, angle[start:end], row[start:end])
    return torque


def assert_same_bits(angle, parameters, starts=(0, 60, 61, 200), initial=(0.0, 0.5, -3.0)):
    motion = np.asarray(angle, dtype=float), np.array(starts), np.array(initial)
    torque = together(*motion, parameters)
    np.testing.assert_array_equal(torque, one_by_one(*motion, parameters))
    return torque


def walk(rng, step):
    return 60 + np.cumsum(rng.normal(0, step, 200))


def test_random_models_are_the_same_to_the_last_bit():
    for step in [1e-3, 0.1, 1.0, 10.0, 1e3]:
        rng = np.random.default_rng(1)
        torque = assert_same_bits(walk(rng, step), rng.uniform(LOW, HIGH, (200, 5)))
        meets_the_pole = np.isnan(torque).any(axis=1)
        assert not meets_the_pole.all()
        assert meets_the_pole.any() or step < 0.1


def test_any_number_of_rows():
    for rows in [*range(18), 31, 32, 33, 65]:
        rng = np.random.default_rng(rows)
        assert_same_bits(walk(rng, 1.0), rng.uniform(LOW, HIGH, (rows, 5)))


def test_an_angle_that_is_not_finite_ends_the_motion():
    rng = np.random.default_rng(4)
    angle = walk(rng, 0.5)
    angle[100], angle[150] = np.nan, np.inf
    torque = assert_same_bits(angle, np.array(list(TABLE_2.values())))
    assert np.isfinite(torque[:, :100]).all()
    assert np.isnan(torque[:, 100:]).all()


TINY = 1e-30


def with_derivatives(angle, row, initial=0.0):
    torque, derivatives = np.empty(angle.size), np.empty((angle.size, 6))
    starts = np.array([0, angle.size])
    kernels.response_and_derivatives(angle, starts, np.array([initial]), row, torque, derivatives)
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
    kernels.population_response(angle, starts, np.tile(initial, (200, 1)), rows, expected)
    assert 20 < np.isnan(expected).any(axis=1).sum() < 180  # some meet their pole, some do not
    for row, of_population in zip(rows, expected, strict=True):
        torque, derivatives = np.empty(angle.size), np.empty((angle.size, 6))
        kernels.response_and_derivatives(angle, starts, initial, row, torque, derivatives)
        np.testing.assert_array_equal(torque, of_population)
        assert np.isfinite(derivatives[np.isfinite(torque)]).all()
