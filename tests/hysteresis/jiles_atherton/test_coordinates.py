"""The Langevin function, and the coordinates in which all certified models lie in a box."""

import math

import mpmath
import numpy as np
import pytest
from activesuit.hysteresis import JilesAtherton
from activesuit.hysteresis.jiles_atherton import coordinates
from activesuit.hysteresis.jiles_atherton.langevin import SERIES_BELOW, langevin
from activesuit.hysteresis.jiles_atherton.model import PARAMETERS
from helpers import TABLE_2


def model_of(row, **unit):
    return JilesAtherton(**dict(zip(PARAMETERS, row, strict=True)), **unit)


def exact(x):
    with mpmath.workdps(60):
        x = mpmath.mpf(x)
        slope, bend = 1 / x**2 - mpmath.csch(x) ** 2, mpmath.coth(x) * mpmath.csch(x) ** 2
        return mpmath.coth(x) - 1 / x, slope, 2 * bend - 2 / x**3


def test_value_and_slope_are_exact_to_1e_14_and_the_curvature_predicts():
    for sign in [1, -1]:
        near_the_switch = np.linspace(0.9, 1.1, 101) * SERIES_BELOW
        for x in np.concatenate([np.logspace(-12, 5, 600), near_the_switch]):
            value, slope, curvature = langevin(sign * float(x))
            true_value, true_slope, true_curvature = exact(sign * float(x))
            assert abs(value / true_value - 1) < 1e-14
            assert abs(slope / true_slope - 1) < 1e-14
            assert abs(curvature / true_curvature - 1) < 1e-4


def test_zero_and_huge_arguments():
    assert langevin(0.0) == (0.0, 1 / 3, 0.0)
    value, slope, _ = langevin(1e300)
    assert value == 1.0
    assert slope == pytest.approx(0.0)
    assert all(math.isfinite(part) for part in langevin(-750.0))


def test_there_and_back():
    for name in TABLE_2:
        row = np.array(TABLE_2[name])
        point = coordinates.point(row)
        np.testing.assert_allclose(coordinates.rows(point[None])[0], row, rtol=1e-12)


def test_every_steepness_between_the_limits_is_certified():
    rng = np.random.default_rng(0)
    least, most = coordinates.STEEPNESS_LIMITS
    low = np.array([0.0, least + 1e-6, -4.0, 0.0, -1.0])
    high = np.array([8.0, most - 1e-6, 3.0, 9.0, 4.0])
    for row in coordinates.rows(rng.uniform(low, high, (200, 5))):
        assert model_of(row).certificate().certified
    (row,) = coordinates.rows(np.array([[5.0, most + 1e-3, 1.0, 3.0, 2.0]]))
    assert not model_of(row).certificate().certified


def test_at_one_shape_the_torque_is_proportional_to_ms():
    shape = np.array([5.0, 0.4, 1.0, 4.0])
    unit = coordinates.unit_rows(shape[None])[0]
    (row,) = coordinates.rows(np.append(shape, np.log(7.0))[None])
    angle = np.array([0.0, 0.6, 0.2, 1.0])
    one, seven = (model_of(one, angle_unit="deg").response(angle) for one in (unit, row))
    np.testing.assert_allclose(seven, 7 * one, rtol=1e-6)
