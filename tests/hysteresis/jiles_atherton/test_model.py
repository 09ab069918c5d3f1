"""The model against eq. (4) integrated by SciPy, its invariances, and its borders."""

import math
from dataclasses import replace

import numpy as np
import pytest
from activesuit.hysteresis import JilesAtherton, PoleError
from helpers import assert_refused, sweep


def test_published_turning_torques(shoulder):
    # Independent computation with RK4 (rounded): no clamp, 0.35-1.22 rad, torque at the turns.
    torque = shoulder.response([0.35, *(1.22, 0.35) * 3])
    np.testing.assert_allclose(torque[1:], [9.76, -6.35, 8.76, -6.42, 8.75, -6.42], atol=0.01)


def test_work_of_a_cycle_has_the_sign_of_c_minus_1(elbow):
    def work(c):
        model = replace(elbow, c=c, allow_active=True)
        angle = sweep(0.5, *(1.5, 0.5) * 6, samples=400)
        torque = model.response(angle)
        last = slice(-799, None)
        return np.trapezoid(torque[last], angle[last])

    assert work(0.5) < -1e-3
    assert abs(work(1.0)) < 1e-6
    assert work(2.0) > 1e-3


def test_tiny_and_huge_steps(elbow):
    here = elbow.start(0.8, 1.0)
    _, torque = elbow.step(here, 0.8 + 1e-12)
    assert torque == pytest.approx(1.0 + 1e-12 * elbow.tangent(here, 1), abs=1e-13)
    far = math.radians(10_000)
    torque = elbow.response([0.0, far])[-1]
    fine = elbow.response(np.linspace(0, far, 20_000))[-1]
    assert torque == pytest.approx(fine, abs=1e-6)
    assert torque < elbow.Ms


def test_any_finite_angle_is_reached_at_once(table_2):
    for angle in [1e7, 1e300, -1e9]:
        for model in table_2.values():
            if model.certificate().certified:
                assert abs(model.response([0.0, angle])[-1]) <= model.certificate().torque_bound
        sharp = JilesAtherton(Ms=1, a=1e-85, alpha=0, c=2, k=1)
        assert sharp.response([0.0, 0.1])[-1] == pytest.approx(1 + math.exp(-0.1), rel=1e-6)


def test_angle_unit_does_not_matter(elbow):
    angle = sweep(0.35, 1.2, 0.5, 1.0)
    radians = elbow.in_unit("rad")
    assert radians.a == pytest.approx(math.radians(elbow.a))
    np.testing.assert_allclose(radians.response(angle), elbow.response(angle), atol=1e-11)


def test_pole_is_an_error_that_says_where(shoulder):
    with pytest.raises(PoleError, match=r"infinite between 1\.57.* rad .*margin is -0\.24"):
        shoulder.response(sweep(0.0, math.pi / 2, 0.0))
    state = shoulder.start(0.0)
    state, _ = shoulder.step(state, math.pi / 2)
    with pytest.raises(PoleError):
        shoulder.step(state, 0.0)


def test_bad_parameters(elbow):
    rows = [
        ({"Ms": 0.0}, r"Ms is 0\.0 N·m: give a number above 0"),
        ({"a": -1.0}, r"a is -1\.0 deg: give a number above 0"),
        ({"k": 0.0}, r"k is 0\.0 deg: give a number above 0"),
        ({"alpha": math.nan}, "alpha is nan: give a finite number"),
        ({"k": math.inf}, "k is inf: give a finite number"),
        ({"c": 0.5}, "c is 0.5: below 1 .* allow_active=True"),
        ({"Ms": "big"}, "Ms is 'big': give a number"),
        ({"angle_unit": "grad"}, "angle_unit is 'grad': use 'rad' or 'deg'"),
    ]
    assert_refused(lambda change: replace(elbow, **change), rows)
