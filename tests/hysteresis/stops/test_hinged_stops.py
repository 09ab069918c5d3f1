"""Hinged stops: their hinge, starts and certificates."""

import math

import numpy as np
import pytest
from activesuit.hysteresis import HingedStops
from helpers import assert_refused
from hypothesis import strategies as st
from stop_models import for_any, paths


def simple(**change):
    values = {
        "stiffness": 1.0,
        "thresholds": [0.1, 0.3],
        "weights": [5.0, 2.0],
        "knots": [-0.5, 1.0],
        "slopes": [0.5, 1.0, 2.0],
        "offset": 0.25,
        "rest_angle": 0.2,
    }
    return HingedStops(**{**values, **change})


def test_a_start_takes_the_least_motion():
    # h is flat from 0.5 to 1: a torque of 0.5 is there from x = 0.1 rad on.
    model = simple(stiffness=0, thresholds=[1], weights=[5], knots=[0.5, 1], slopes=[1, 0, 1])
    for torque, x in ((0.5, 0.1), (0.51, 0.202), (0.0, 0.0), (-0.5, -0.1)):
        found = model.start(0.7, 0.25 + torque).memory[3:]
        np.testing.assert_allclose(found, 0.7 - x)


@for_any(st.integers(0, 2**32), paths)
def test_a_straight_hinge_is_prandtl_ishlinskii(seed, path):
    rng = np.random.default_rng(seed)
    line = simple(slopes=[2.5, 2.5, 2.5], offset=0.0, weights=rng.uniform(0, 5, 2))
    stops = line.stops.scaled(torque=2.5)
    first = stops.stiffness * (path[0] - stops.rest_angle)
    torque, expected = line.response(path, first), stops.response(path, first)
    np.testing.assert_allclose(torque, expected, atol=1e-12)


def test_certificates():
    # P ends at 0.8 + 1.1 and at -1.2 - 1.1, where h is 1 + 2 * 0.9 and -0.5 - 0.5 * 1.8.
    whole, here = simple().certificate(), simple().certificate((-1.0, 1.0))
    assert (whole.margin, whole.certified, whole.dissipative) == (1.0, True, True)
    assert (whole.torque_bound, whole.memory_bound) == (math.inf, pytest.approx(2 * 1.1))
    assert (here.angle_range, here.torque_bound) == ((-1.0, 1.0), pytest.approx(0.25 + 2.8))
    assert simple().response([0.2, 1.0], 0.25)[-1] == pytest.approx(0.25 + 2.8)
    assert simple().response([0.2, -1.0], 0.25)[-1] == pytest.approx(0.25 - 1.4)
    assert simple(stiffness=0.0).certificate().torque_bound == pytest.approx(0.25 + 1.2)
    assert simple(slopes=[0, 1, 0]).certificate().torque_bound == pytest.approx(0.25 + 1.0)


def test_tangent_on_a_knot_is_that_of_the_side_where_the_motion_goes():
    state = simple(knots=[-0.5, 0.0]).start(0.2, 0.25)
    assert simple(knots=[-0.5, 0.0]).tangent(state, 1) == pytest.approx(2 * 8)
    assert simple(knots=[-0.5, 0.0]).tangent(state, -1) == pytest.approx(1 * 8)


def test_bad_input():
    rows = [
        ({"stiffness": "big"}, "stiffness is 'big': give a number"),
        ({"stiffness": -1.0}, r"stiffness is -1\.0 N·m/rad: give numbers of at least 0"),
        ({"weights": [5.0]}, r"weights is \(5\.0,\) N·m/rad: give as many numbers as thresholds"),
        ({"weights": [5.0, -2.0]}, r"weights is \(5\.0, -2\.0\) N·m/rad: give numbers of at"),
        ({"thresholds": [0.3, 0.3]}, "thresholds is .* rad: give increasing numbers above 0"),
        ({"rest_angle": math.nan}, "rest_angle is nan: give a finite number"),
        ({"offset": math.inf}, r"offset is inf: give a finite number \(N·m\)"),
        ({"knots": []}, r"knots is \[\]: give at least one number \(N·m\)"),
        ({"knots": [1.0, 1.0]}, r"knots is \(1\.0, 1\.0\) N·m: give 1 to 16 increasing numbers"),
        ({"knots": [1.0]}, "slopes is .*: give one number more than knots"),
        ({"knots": range(17), "slopes": [1] * 18}, "knots is .*: give 1 to 16"),
        ({"slopes": [1.0, math.nan, 1.0]}, r"slopes\[1\] is nan: give finite numbers"),
        ({"slopes": [1.0, 1.0, -0.1]}, "slopes is .*: give numbers of at least 0"),
    ]
    assert_refused(lambda change: simple(**change), rows)
    words = r"9 N·m at 0.2 rad: .* -0.55 to 1.45 .*; give a torque"
    assert_refused(simple().start, [(0.2, 9.0, words)])
