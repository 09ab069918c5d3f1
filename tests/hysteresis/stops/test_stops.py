"""Models of stops, with and without a hinge, against operators in plain Python."""

import math
from itertools import pairwise

import numpy as np
import pytest
from activesuit.benchmarks.references import reference_of
from activesuit.hysteresis import HingedStops, PrandtlIshlinskii
from helpers import assert_refused
from hypothesis import strategies as st
from stop_models import angles, for_any, hinged, paths, stops

models = st.one_of(stops(), hinged())


def resting(model, angle):
    """The readable model, with all stops at zero."""
    return reference_of(model, np.array([angle]), 0.0)


def run(model, path):
    """The states along a path that begins with all stops at zero."""
    states = [model.start(path[0], resting(model, path[0]).torque)]
    for angle in path[1:]:
        states.append(model.step(states[-1], angle)[0])
    return states


def knees(operators, end):
    """Angles on the way to `end` where the slope changes."""
    low, high = sorted((operators.angle, end))
    ahead = [x for x in operators.knots(end) if low + 1e-12 < x < high - 1e-12]
    return sorted(ahead, key=lambda x: abs(x - operators.angle))


@for_any(models, angles, paths)
def test_agrees_with_the_operators(model, origin, path):
    operators = resting(model, origin)
    torque = model.response([origin, *path], operators.torque)
    np.testing.assert_allclose(torque[1:], [operators.move(angle) for angle in path], atol=1e-11)


@for_any(st.one_of(stops(idle=False), hinged(idle=False)), angles, paths)
def test_a_start_is_the_end_of_a_first_loading(model, origin, path):
    operators = resting(model, origin)
    initial = operators.move(path[0])
    expected = [initial, *(operators.move(angle) for angle in path[1:])]
    assert model.start(path[0], initial).torque == initial
    np.testing.assert_allclose(model.response(path, initial), expected, atol=1e-10)


@for_any(models, paths)
def test_work_is_stored_or_dissipated(model, path):
    # The torque is linear from knee to knee, so that the trapezoidal rule is exact.
    operators, fine = resting(model, path[0]), [path[0]]
    for angle in path[1:]:
        fine += [*knees(operators, angle), angle]
        operators.move(angle)
    torque = model.response(fine, resting(model, path[0]).torque)
    work = np.diff(fine) * (torque[1:] + torque[:-1]) / 2
    energies = [model.energy(state) for state in run(model, path)]
    scale = np.abs(work).sum() + abs(energies[0].stored) + abs(energies[-1].stored)
    change = sum(energies[-1]) - sum(energies[0])
    assert change == pytest.approx(work.sum(), abs=1e-11 * scale + 1e-13)
    if model.certificate().dissipative:
        assert all(b.dissipated >= a.dissipated for a, b in pairwise(energies))


@for_any(models, paths, st.lists(st.floats(0, 1), max_size=20), angles)
def test_samples_and_closed_excursions_leave_no_trace(model, path, inner, turn):
    start = path[-1]
    inside = np.clip([turn + x * (start - turn) for x in inner], min(start, turn), max(start, turn))
    on_the_way = sorted(inside, key=lambda angle: abs(angle - start))
    before = run(model, [*path, turn])[-1]
    after = run(model, [*path, *on_the_way, turn, *inside, turn])[-1]
    assert after.torque == before.torque
    assert np.array_equal(after.memory[3:], before.memory[3:])


@for_any(models, paths)
def test_the_torque_bound_holds(model, path):
    certificate = model.certificate((min(path), max(path) + 1e-9))
    torque = model.response(path, resting(model, path[0]).torque)
    assert np.abs(torque).max() <= certificate.torque_bound * (1 + 1e-12) + 1e-13
    if isinstance(model, PrandtlIshlinskii):
        elastic = model.parameter_vector[0] * (np.array(path) - model.rest_angle)
        assert np.abs(torque - elastic).max() <= certificate.memory_bound * (1 + 1e-12) + 1e-13


def test_saturated_states_are_starts():
    many = {"stiffness": 3.3, "thresholds": np.arange(1, 21) / 30, "weights": np.full(20, 0.7)}
    for model in (
        PrandtlIshlinskii(**many, rest_angle=0.2),
        HingedStops(**many, rest_angle=0.2, knots=[-0.5, 1.0], slopes=[0.5, 1.0, 2.0]),
        HingedStops(**many, rest_angle=0.2, knots=[-0.5, 1.0], slopes=[0.0, 1.0, 0.0]),
    ):
        for angle in np.random.default_rng(4).uniform(-9, 9, 50):
            assert model.start_is_certified(run(model, [0.2, angle])[-1])


STOPS = {"stiffness": 1.0, "thresholds": [0.1, 0.3], "weights": [5.0, 2.0], "rest_angle": 0.2}


def simple(**change):
    return PrandtlIshlinskii(**STOPS | change)


def test_a_start_takes_the_least_motion_and_a_jump_is_one_step():
    # h is flat from 0.5 to 1: a torque of 0.5 is there from x = 0.1 rad on.
    model = hinge(stiffness=0, thresholds=[1], weights=[5], knots=[0.5, 1], slopes=[1, 0, 1])
    for torque, x in ((0.5, 0.1), (0.51, 0.202), (0.0, 0.0), (-0.5, -0.1)):
        np.testing.assert_allclose(model.start(0.7, 0.25 + torque).memory[3:], 0.7 - x)
    far = simple(stiffness=0.0).response([0.2, 1e300, -1e300])
    np.testing.assert_allclose(far, [0.0, 1.1, -1.1])
    # The first loading rises to 1 at 0.5 rad, falls to -1 at 1.5 rad.
    model = simple(stiffness=0.0, thresholds=[0.5, 1.5], weights=[4.0, -2.0])
    for torque in (0.5, -0.5, 1.0, -1.0, 0.0):
        np.testing.assert_allclose(model.start(0.7, torque).memory[3:], 0.7 - torque / 2)
    # No slope up to 0.5 rad, then down.
    model = simple(stiffness=0.0, thresholds=[0.5, 1.5], weights=[2.0, -2.0])
    np.testing.assert_allclose(model.start(0.7, 1.0).memory[3:], [1.2, 1.7])


def test_certificates():
    whole, here = simple().certificate(), simple().certificate((-1.0, 1.0))
    assert (whole.margin, whole.certified, whole.dissipative) == (1.0, True, True)
    assert (whole.torque_bound, whole.memory_bound) == (math.inf, pytest.approx(1.1))
    assert (here.angle_range, here.torque_bound) == ((-1.0, 1.0), pytest.approx(1.2 + 1.1))
    assert simple().response([0.2, -1.0])[-1] == pytest.approx(-here.torque_bound)
    assert simple(stiffness=0.0).certificate().torque_bound == pytest.approx(1.1)
    assert not simple(weights=[5.0, -2.0]).certificate().dissipative
    assert not simple(operator="play").certificate().dissipative
    play = simple(operator="play", weights=[-3.0, -1.0], stiffness=6.0)
    assert play.certificate().dissipative
    assert play.certificate((0.2, 1.2)).torque_bound == pytest.approx(2.0 + 0.6)


def test_bad_input():
    rows = [
        ({"operator": "slide"}, "operator is 'slide': use 'stop' or 'play'"),
        ({"stiffness": "big"}, "stiffness is 'big': give a number"),
        ({"rest_angle": math.nan}, "rest_angle is nan: give a finite number"),
        ({"weights": [5.0]}, "weights is .*: give as many numbers as thresholds"),
        ({"weights": 5.0}, "weights is 5.0: give at least one number"),
        ({"thresholds": [], "weights": []}, r"thresholds is \[\]: give at least one number"),
        ({"thresholds": ["0.1", "0.3"]}, "thresholds is .*: give at least one number"),
        ({"thresholds": [0.0, 0.3]}, "thresholds is .* rad: give increasing numbers above 0"),
    ]
    assert_refused(lambda change: simple(**change), rows)
    words = r"0 N·m at 1.2 rad: .* 0.4 to 1.6 .*; give a torque"
    assert_refused(simple(weights=[3.0, 1.0]).start, [(1.2, words)])


def hinge(**change):
    hinges = {"knots": [-0.5, 1.0], "slopes": [0.5, 1.0, 2.0], "offset": 0.25}
    return HingedStops(**STOPS | hinges | change)


def test_certificates_with_a_hinge():
    # P ends at 0.8 + 1.1 and at -1.2 - 1.1, where h is 1 + 2 * 0.9 and -0.5 - 0.5 * 1.8.
    whole, here = hinge().certificate(), hinge().certificate((-1.0, 1.0))
    assert (whole.margin, whole.certified, whole.dissipative) == (1.0, True, True)
    assert (whole.torque_bound, whole.memory_bound) == (math.inf, pytest.approx(2 * 1.1))
    assert (here.angle_range, here.torque_bound) == ((-1.0, 1.0), pytest.approx(0.25 + 2.8))
    assert hinge().response([0.2, 1.0], 0.25)[-1] == pytest.approx(0.25 + 2.8)
    assert hinge().response([0.2, -1.0], 0.25)[-1] == pytest.approx(0.25 - 1.4)
    assert hinge(stiffness=0.0).certificate().torque_bound == pytest.approx(0.25 + 1.2)
    assert hinge(slopes=[0, 1, 0]).certificate().torque_bound == pytest.approx(0.25 + 1.0)


def test_tangent_on_a_knot_is_that_of_the_side_where_the_motion_goes():
    state = hinge(knots=[-0.5, 0.0]).start(0.2, 0.25)
    assert hinge(knots=[-0.5, 0.0]).tangent(state, 1) == pytest.approx(2 * 8)
    assert hinge(knots=[-0.5, 0.0]).tangent(state, -1) == pytest.approx(1 * 8)


def test_bad_input_with_a_hinge():
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
    assert_refused(lambda change: hinge(**change), rows)
    words = r"9 N·m at 0.2 rad: .* -0.55 to 1.45 .*; give a torque"
    assert_refused(hinge().start, [(0.2, 9.0, words)])
