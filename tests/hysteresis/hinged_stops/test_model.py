"""Hinged stops against operators in plain Python; their proof of dissipation, put to the test."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import HingedStops
from activesuit.hysteresis.hinged_stops import kernels
from activesuit.hysteresis.references.hinged_stops import HingedStopsReference
from helpers import assert_refused, sweep
from hypothesis import given, settings
from hypothesis import strategies as st


def for_any(*strategies):
    """`given`, with time for the kernels to compile."""
    return lambda test: settings(deadline=None)(given(*strategies)(test))


angles = st.floats(-2.0, 2.0, allow_subnormal=False)
paths = st.lists(angles, min_size=2, max_size=30)


@st.composite
def models(draw, flat=True):
    """Models of any kind; with `flat` pieces of h, without a spring, and with idle stops."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    stops, hinges = rng.integers(1, 7, 2)
    some = (lambda size: rng.integers(0, 2, size)) if flat else np.ones
    return HingedStops(
        stiffness=float(some(1)[0] * rng.uniform(0.3, 3)),
        thresholds=np.cumsum(rng.uniform(0.01, 0.5, stops)),
        weights=some(stops) * rng.uniform(0.1, 5, stops),
        knots=np.cumsum(rng.uniform(0.05, 2, hinges)) - rng.uniform(0, 5),
        slopes=some(hinges + 1) * rng.uniform(0.1, 3, hinges + 1),
        offset=rng.normal(),
        rest_angle=rng.uniform(-0.5, 0.5),
    )


def reference(model, angle):
    """The readable model, with all stops at zero."""
    return HingedStopsReference(model, np.array([angle]), 0.0)


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


def response(model, path):
    """The torque along a path that begins with all stops at zero."""
    return model.response(path, reference(model, path[0]).torque)


def run(model, path):
    """The states along such a path."""
    states = [model.start(path[0], reference(model, path[0]).torque)]
    for angle in path[1:]:
        states.append(model.step(states[-1], angle)[0])
    return states


@for_any(models(), angles, paths)
def test_agrees_with_the_operators(model, origin, path):
    resting = reference(model, origin)
    torque = model.response([origin, *path], resting.torque)
    np.testing.assert_allclose(torque[1:], [resting.move(angle) for angle in path], atol=1e-11)


@for_any(models(flat=False), angles, paths)
def test_a_start_is_the_end_of_a_first_loading(model, origin, path):
    resting = reference(model, origin)
    initial = resting.move(path[0])
    expected = [initial, *(resting.move(angle) for angle in path[1:])]
    assert model.start(path[0], initial).torque == initial
    np.testing.assert_allclose(model.response(path, initial), expected, atol=1e-10)


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


@for_any(models(), paths)
def test_work_is_stored_or_dissipated(model, path):
    # The torque is linear from knee to knee, so that the trapezoidal rule is exact.
    resting, fine = reference(model, path[0]), [path[0]]
    for angle in path[1:]:
        sign = math.copysign(1.0, angle - resting.angle)
        low, high = sorted((resting.angle, angle))
        knees = [x for x in resting.knots(angle) if low + 1e-12 < x < high - 1e-12]
        fine += [*sorted(knees, key=lambda x, sign=sign: sign * x), angle]
        resting.move(angle)
    torque = response(model, fine)
    work = np.diff(fine) * (torque[1:] + torque[:-1]) / 2
    first, *_, last = [model.energy(state) for state in run(model, path)]
    scale = np.abs(work).sum() + abs(first.stored) + abs(last.stored)
    assert sum(last) - sum(first) == pytest.approx(work.sum(), abs=1e-11 * scale + 1e-13)


def returns(p, size, rng):
    """The work of a random closed cycle over the area it spans, from the torque alone.

    It is the second run of the cycle, whose memory is the same at both ends.
    """
    turns = rng.normal(0, 10 ** rng.uniform(-1, 0), rng.integers(2, 12))
    angle, memory = sweep(*turns, turns[0], samples=150), np.zeros(size)
    torque = np.zeros_like(angle)
    for _ in range(2):
        memory[:2] = angle[0], torque[-1]
        kernels.response(p, memory, angle, torque)
    return np.trapezoid(torque, angle) / max(np.ptp(torque) * np.ptp(angle), 1e-9)


@pytest.mark.slow
def test_closed_cycles_of_random_models_and_motions_dissipate():
    rng = np.random.default_rng(0)
    found = []
    for _ in range(250):
        stops, hinges = rng.integers(1, 9), rng.integers(1, 7)
        model = HingedStops(
            stiffness=rng.choice([0, rng.uniform(0, 3)]),
            thresholds=np.cumsum(rng.uniform(0.01, 0.4, stops)),
            weights=rng.uniform(0, 5, stops),
            knots=np.cumsum(rng.uniform(0.05, 2, hinges)) - rng.uniform(0, 5),
            slopes=rng.integers(0, 2, hinges + 1) * 10 ** rng.uniform(-1, 1, hinges + 1),
            offset=rng.normal(),
        )
        p, size = model.parameter_vector.copy(), model.memory_size
        found += [returns(p, size, rng) for _ in range(40)]
    assert len(found) == 10_000
    assert min(found) > -1e-3  # the trapezoidal rule across knees
    assert np.mean(np.array(found) > 1e-3) > 0.4
    # The same cycles detect a hinge that falls.
    falling = simple().parameter_vector.copy()
    hinge = falling[-kernels.HINGE :]
    hinge[kernels.SLOPES : kernels.SLOPES + 3] *= -1
    hinge[kernels.VALUES : kernels.VALUES + 2] *= -1
    assert min(returns(falling, simple().memory_size, rng) for _ in range(40)) < -0.1


@for_any(models(), paths, st.lists(st.floats(0, 1), max_size=20), angles)
def test_samples_and_closed_excursions_leave_no_trace(model, path, inner, turn):
    start = path[-1]
    inside = np.clip([turn + x * (start - turn) for x in inner], min(start, turn), max(start, turn))
    on_the_way = sorted(inside, key=lambda angle: abs(angle - start))
    before = run(model, [*path, turn])[-1]
    after = run(model, [*path, *on_the_way, turn, *inside, turn])[-1]
    assert after.torque == before.torque
    assert np.array_equal(after.memory[3:], before.memory[3:])


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


def test_tangent_is_the_slope_up_to_the_next_knee():
    for seed in range(20):
        path = 0.2 + 0.4 * np.random.default_rng(seed).standard_normal(9)
        model, resting = simple(), reference(simple(), path[0])
        state = run(model, path)[-1]
        for angle in path[1:]:
            resting.move(angle)
        for far in (-5.0, 5.0):
            low, high = sorted((resting.angle, far))
            ahead = [x for x in resting.knots(far) if low + 1e-12 < x < high - 1e-12]
            end = min([*ahead, far], key=lambda x: abs(x - resting.angle))
            slope = (model.step(state, end)[1] - state.torque) / (end - state.angle)
            assert model.tangent(state, far) == pytest.approx(slope, abs=1e-9)


def test_tangent_on_a_knot_is_that_of_the_side_where_the_motion_goes():
    state = simple(knots=[-0.5, 0.0]).start(0.2, 0.25)
    assert simple(knots=[-0.5, 0.0]).tangent(state, 1) == pytest.approx(2 * 8)
    assert simple(knots=[-0.5, 0.0]).tangent(state, -1) == pytest.approx(1 * 8)


@for_any(models())
def test_the_hinge_is_zero_at_zero_and_has_its_slopes(model):
    assert model.hinge(0.0) == 0.0
    ends = [model.knots[0] - 1, *model.knots, model.knots[-1] + 1]
    slopes = [(model.hinge(b) - model.hinge(a)) / (b - a) for a, b in pairwise(ends)]
    np.testing.assert_allclose(slopes, model.slopes, atol=1e-11)


def test_kernels_return_nan_where_there_is_no_motion():
    p, memory = simple().parameter_vector.copy(), simple().start(0.2, 0.25).memory.copy()
    torque = np.empty(4)
    kernels.response(p, memory, np.array([0.2, 0.3, math.nan, 0.4]), torque)
    np.testing.assert_array_equal(np.isnan(torque), [False, False, True, True])
    assert memory[0] == 0.3
    assert math.isnan(kernels.move(p, memory, math.inf)[0])


def test_saturated_states_are_starts():
    model = simple(stiffness=3.3, thresholds=np.arange(1, 21) / 30, weights=np.full(20, 0.7))
    for angle in np.random.default_rng(4).uniform(-9, 9, 50):
        assert model.start_is_certified(run(model, [0.2, angle])[-1])
    flat = replace(model, slopes=(0.0, 1.0, 0.0))
    for angle in (-5.0, 5.0):
        assert flat.start_is_certified(run(flat, [0.2, angle])[-1])


def test_bad_parameters():
    rows = [
        ({"stiffness": "big"}, "stiffness is 'big': give a number"),
        ({"stiffness": -1.0}, r"stiffness is -1\.0: it must be at least 0, or the model would"),
        ({"weights": [5.0]}, "1 weights for 2 thresholds: give one weight for each"),
        ({"weights": [5.0, -2.0]}, r"weights\[1\] is -2\.0: it must be at least 0"),
        ({"thresholds": [0.3, 0.3]}, r"thresholds\[1\] is 0.3 rad: it must be above 0.3;"),
        ({"rest_angle": math.nan}, "rest_angle is nan: give a finite number"),
        ({"offset": math.inf}, r"offset is inf: give a finite number \(N·m\)"),
        ({"knots": []}, r"knots is \[\]: give at least one number \(N·m\)"),
        ({"knots": [1.0, 1.0]}, r"knots\[1\] is 1.0 N·m: it must be above 1.0; give knots in inc"),
        ({"knots": [1.0]}, "3 slopes for 1 knots: give one slope below the first knot and one"),
        ({"knots": range(17), "slopes": [1] * 18}, "there are 17 knots: give at most 16"),
        ({"slopes": [1.0, math.nan, 1.0]}, r"slopes\[1\] is nan: give finite numbers"),
        ({"slopes": [1.0, 1.0, -0.1]}, r"slopes\[2\] is -0\.1: it must be at least 0"),
    ]
    assert_refused(lambda change: simple(**change), rows)


def test_a_torque_that_no_first_loading_has():
    with pytest.raises(InputError, match=r"9 N·m at 0.2 rad: .* -0.55 to 1.45 .*; give a torque"):
        simple().start(0.2, 9.0)
