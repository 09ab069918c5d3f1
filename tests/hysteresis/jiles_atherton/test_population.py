"""Many models at once against the models one by one."""

import numpy as np
from activesuit.hysteresis.jiles_atherton import kernels
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


def test_saturating_beside_gentle_models():
    rng = np.random.default_rng(2)
    parameters = rng.uniform(LOW, HIGH, (40, 5))
    parameters[:, 2] = 0.0  # no pole
    parameters[::2, [1, 4]] = rng.uniform(3, 40, (20, 2))
    assert np.isfinite(assert_same_bits(walk(rng, 2.0), parameters)).all()


def test_a_model_at_its_pole_stays_nan_and_harms_no_other():
    parameters = np.array([TABLE_2["elbow-sa-pso"], TABLE_2["shoulder-sa-pso"]])
    angle = np.degrees(sweep(0.0, np.pi / 2, 0.0))
    both = assert_same_bits(angle, parameters, (0, angle.size), (0.0,))
    assert np.isfinite(both[0]).all()
    assert np.isnan(both[1, np.isnan(both[1]).argmax() :]).all()
    assert np.isnan(both[1, -1])


def test_an_angle_that_is_not_finite_ends_the_motion():
    rng = np.random.default_rng(4)
    angle = walk(rng, 0.5)
    angle[100], angle[150] = np.nan, np.inf
    torque = assert_same_bits(angle, np.array(list(TABLE_2.values())))
    assert np.isfinite(torque[:, :100]).all()
    assert np.isnan(torque[:, 100:]).all()
