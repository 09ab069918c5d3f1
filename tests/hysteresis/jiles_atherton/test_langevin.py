import math

import mpmath
import numpy as np
import pytest
from activesuit.hysteresis.jiles_atherton.langevin import SERIES_BELOW, langevin


def exact(x):
    with mpmath.workdps(60):
        x = mpmath.mpf(x)
        return mpmath.coth(x) - 1 / x, 1 / x**2 - mpmath.csch(x) ** 2


def test_value_and_slope_are_exact_to_1e_14():
    for sign in [1, -1]:
        near_the_switch = np.linspace(0.9, 1.1, 101) * SERIES_BELOW
        for x in np.concatenate([np.logspace(-12, 5, 600), near_the_switch]):
            value, slope, _ = langevin(sign * float(x))
            true_value, true_slope = exact(sign * float(x))
            assert abs(value / true_value - 1) < 1e-14
            assert abs(slope / true_slope - 1) < 1e-14


def test_zero_and_huge_arguments():
    assert langevin(0.0) == (0.0, 1 / 3, 0.0)
    value, slope, _ = langevin(1e300)
    assert value == 1.0
    assert slope == pytest.approx(0.0)
    assert all(math.isfinite(part) for part in langevin(-750.0))


def test_curvature_predicts():
    for x in (1e-3, 0.1, 0.34, 0.36, 1.0, 5.0):
        with mpmath.workdps(60):
            true = mpmath.diff(lambda y: mpmath.coth(y) - 1 / y, x, 2)
        assert langevin(x)[2] == pytest.approx(float(true), rel=1e-4)
