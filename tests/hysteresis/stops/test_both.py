"""Models of stops, with and without a hinge, against operators in plain Python; invariants."""

from itertools import pairwise

import numpy as np
import pytest
from activesuit.benchmarks.references import reference_of
from activesuit.hysteresis import HingedStops, PrandtlIshlinskii
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
