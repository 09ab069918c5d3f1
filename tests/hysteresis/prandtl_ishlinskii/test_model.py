"""The model against operators in plain Python and MuJoCo's own plastic springs; its invariants."""

import math

import mujoco
import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis.prandtl_ishlinskii import kernels
from activesuit.hysteresis.prandtl_ishlinskii.model import PrandtlIshlinskii
from activesuit.hysteresis.references.prandtl_ishlinskii import PrandtlIshlinskiiReference
from helpers import assert_refused, sweep
from hypothesis import given, settings
from hypothesis import strategies as st


def for_any(*strategies):
    """`given`, with time for the kernels to compile."""
    return lambda test: settings(deadline=None)(given(*strategies)(test))


ANY = (1, -1)
angles = st.floats(-2.0, 2.0, allow_subnormal=False)
paths = st.lists(angles, min_size=2, max_size=30)


@st.composite
def models(draw, signs=(1,)):
    """Models that lose energy (signs 1) or not (also -1), rising everywhere."""
    operator = draw(st.sampled_from(["stop", "play"]))
    elements = st.tuples(st.floats(0.01, 0.5), st.floats(0.1, 5.0), st.sampled_from(signs))
    steps, sizes, sign = np.transpose(draw(st.lists(elements, min_size=1, max_size=6)))
    weights = sizes * sign * (1 if operator == "stop" else -1)
    return PrandtlIshlinskii(
        stiffness=draw(st.floats(0.3, 3.0)) + np.maximum(-weights, 0).sum(),
        thresholds=np.cumsum(steps),
        weights=weights,
        operator=operator,
        rest_angle=draw(st.floats(-0.5, 0.5)),
    )


def reference(model, angle):
    """The readable model, at rest at an angle."""
    return PrandtlIshlinskiiReference(model, np.array([angle]), 0.0)


def knees(resting, end):
    """Angles on the way to `end` where an element begins to slip."""
    low, high = sorted((resting.angle, end))
    sign = math.copysign(1.0, end - resting.angle)
    ahead = [x for x in resting.knots(end) if low + 1e-12 < x < high - 1e-12]
    return sorted(ahead, key=lambda x: sign * x)


def simple(**change):
    values = {"stiffness": 1.0, "thresholds": [0.1, 0.3], "weights": [5.0, 2.0], "rest_angle": 0.2}
    return PrandtlIshlinskii(**{**values, **change})


def response(model, path):
    """The torque along a path that begins with all stops at zero."""
    return model.response(path, reference(model, path[0]).torque)


def run(model, path):
    """The states along such a path."""
    states = [model.start(path[0], reference(model, path[0]).torque)]
    for angle in path[1:]:
        states.append(model.step(states[-1], angle)[0])
    return states


@for_any(models(signs=ANY), angles, paths)
def test_agrees_with_the_operators(model, origin, path):
    resting = reference(model, origin)
    torque = model.response([origin, *path], resting.torque)
    np.testing.assert_allclose(torque[1:], [resting.move(angle) for angle in path], atol=1e-11)


@for_any(models(), angles, paths)
def test_a_start_is_the_end_of_a_first_loading(model, origin, path):
    resting = reference(model, origin)
    initial = resting.move(path[0])
    expected = [initial, *(resting.move(angle) for angle in path[1:])]
    assert model.start(path[0], initial).torque == initial
    np.testing.assert_allclose(model.response(path, initial), expected, atol=1e-11)


def test_a_start_takes_the_least_motion():
    # The first loading rises to 1 at 0.5 rad, falls to -1 at 1.5 rad.
    model = simple(stiffness=0.0, thresholds=[0.5, 1.5], weights=[4.0, -2.0])
    for torque in (0.5, -0.5, 1.0, -1.0, 0.0):
        np.testing.assert_allclose(model.start(0.7, torque).memory[3:], 0.7 - torque / 2)
    # No slope up to 0.5 rad, then down.
    model = simple(stiffness=0.0, thresholds=[0.5, 1.5], weights=[2.0, -2.0])
    np.testing.assert_allclose(model.start(0.7, 1.0).memory[3:], [1.2, 1.7])


def plastic_hinge(path, rest, joint, tendons=""):
    """MuJoCo's resistance [N·m] of a hinge and the tendons on it, along `path`.

    Its yield state advances at the end of mj_step, at the position there; the inertia keeps that
    where it was written. The force then follows from mj_forward.
    """
    model = mujoco.MjModel.from_xml_string(f"""
      <mujoco><compiler angle="radian"/><option timestep="1e-9" gravity="0 0 0"/>
        <worldbody><body><geom size="1"/>
          <joint name="hinge" type="hinge" armature="1e6" springref="{rest}" {joint}/>
        </body></worldbody><tendon>{tendons}</tendon></mujoco>""")
    data = mujoco.MjData(model)
    torque = []
    for angle in path:
        data.qpos[0], data.qvel[0] = angle, 0
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        torque.append(-data.qfrc_passive[0])
    return torque


def test_a_sum_of_stops_is_mujocos_plastic_tendons():
    rng = np.random.default_rng(2)
    path = np.r_[-0.3, np.cumsum(rng.normal(0, 0.3, 300)) - 0.3]
    thresholds, weights = np.cumsum(rng.uniform(0.02, 0.2, 8)), rng.uniform(0.5, 4.0, 8)
    tendons = "".join(
        f'<fixed stiffness="{w}" springyield="{r}"><joint joint="hinge" coef="1"/></fixed>'
        for r, w in zip(thresholds, weights, strict=True)
    )
    expected = plastic_hinge(path, -0.3, 'stiffness="1.3"', tendons)
    model = simple(stiffness=1.3, thresholds=thresholds, weights=weights, rest_angle=-0.3)
    np.testing.assert_allclose(model.response(path), expected, atol=1e-12)


@for_any(models(signs=ANY), paths)
def test_work_is_stored_or_dissipated(model, path):
    # The torque is linear from knee to knee, so that the trapezoidal rule is exact.
    resting, fine = reference(model, path[0]), [path[0]]
    for angle in path[1:]:
        fine += [*knees(resting, angle), angle]
        resting.move(angle)
    torque = response(model, fine)
    work = np.diff(fine) * (torque[1:] + torque[:-1]) / 2
    first, *_, last = [model.energy(state) for state in run(model, path)]
    scale = np.abs(work).sum() + abs(first.stored) + abs(last.stored)
    assert sum(last) - sum(first) == pytest.approx(work.sum(), abs=1e-12 * scale + 1e-15)


@for_any(models(signs=ANY), paths, st.lists(st.floats(0, 1), max_size=20), angles)
def test_samples_and_closed_excursions_leave_no_trace(model, path, inner, turn):
    start = path[-1]
    inside = np.clip([turn + x * (start - turn) for x in inner], min(start, turn), max(start, turn))
    on_the_way = sorted(inside, key=lambda angle: abs(angle - start))
    before = run(model, [*path, turn])[-1]
    after = run(model, [*path, *on_the_way, turn, *inside, turn])[-1]
    assert after.torque == before.torque
    assert np.array_equal(after.memory[3:], before.memory[3:])


@for_any(models(signs=ANY), paths, paths, angles, angles)
def test_loops_between_the_same_angles_are_congruent(model, one, other, low, high):
    loop = sweep(low, high, low, samples=20)
    one = response(model, [*one, low, high, *loop])[-loop.size :]
    other = response(model, [*other, low, high, *loop])[-loop.size :]
    assert one[-1] == one[0]
    np.testing.assert_allclose(one - one[0], other - other[0], atol=1e-11)


@for_any(models(signs=ANY), st.floats(-2, 2), st.floats(0, 2))
def test_branches_are_the_first_loading_twice_as_large(model, peak, part):
    rest = model.rest_angle
    torque = model.response([rest, rest + peak, rest + peak - part * peak])
    _, half = model.response([rest, rest + part * peak / 2])
    assert torque[2] == pytest.approx(torque[1] - 2 * half, abs=1e-11)


@for_any(models(signs=ANY), paths)
def test_the_torque_bound_holds(model, path):
    certificate = model.certificate((min(path), max(path) + 1e-9))
    torque = response(model, path)
    assert np.abs(torque).max() <= certificate.torque_bound * (1 + 1e-14)
    elastic = model.parameter_vector[0] * (np.array(path) - model.rest_angle)
    assert np.abs(torque - elastic).max() <= certificate.memory_bound * (1 + 1e-12) + 1e-13


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


@for_any(models(signs=ANY), angles, angles, st.lists(st.floats(-9, 9), min_size=1, max_size=30))
def test_the_inverse_gives_the_torques_back(model, origin, initial, torque):
    # Any start: somewhere on a first loading.
    torque = [reference(model, origin).move(initial), *torque, torque[-1]]
    angle = model.inverse(torque, initial)
    assert angle[-1] == angle[-2]
    back = model.response(angle, torque[0])
    scale = model.loading_slopes.max() * (1 + np.abs(angle).max())
    np.testing.assert_allclose(back, torque, atol=1e-12 * scale)


def test_no_inverse_where_the_model_does_not_rise():
    rows = [
        ({"stiffness": 0.0}, r"slope 0 N·m/rad beyond 0\.3 rad: .* raise the stiffness by more"),
        ({"weights": [3.0, -3.0]}, r"slope -2 N·m/rad beyond 0\.1 rad: .* more than 2 N·m/rad"),
        ({"stiffness": 0.0, "operator": "play"}, r"slope 0 N·m/rad beyond 0 rad"),
    ]
    assert_refused(lambda change: simple(**change).inverse([0.0, 1.0], 0.2), rows)


def test_tangent_is_the_slope_up_to_the_next_knee():
    for seed in range(20):
        path = 0.2 + 0.4 * np.random.default_rng(seed).standard_normal(9)
        model = simple(operator=("stop", "play")[seed % 2])
        state, resting = run(model, path)[-1], reference(model, path[0])
        for angle in path[1:]:
            resting.move(angle)
        for far in (-5.0, 5.0):
            end = [*knees(resting, far), far][0]
            slope = (model.step(state, end)[1] - state.torque) / (end - state.angle)
            assert model.tangent(state, far) == pytest.approx(slope, abs=1e-9)


def test_kernels_return_nan_where_there_is_no_motion():
    p, memory, torque = (
        simple().parameter_vector.copy(),
        simple().start(0.2).memory.copy(),
        np.empty(4),
    )
    kernels.response(p, memory, np.array([0.2, 0.3, math.nan, 0.4]), torque)
    np.testing.assert_array_equal(np.isnan(torque), [False, False, True, True])
    assert memory[0] == 0.3
    assert math.isnan(kernels.move(p, memory, math.inf)[0])


def test_saturated_states_are_starts():
    model = simple(stiffness=3.3, thresholds=np.arange(1, 21) / 30, weights=np.full(20, 0.7))
    for angle in np.random.default_rng(4).uniform(2, 9, 50):
        assert model.start_is_certified(run(model, [0.2, angle])[-1])
    far = simple(stiffness=0.0).response([0.2, 1e300, -1e300])
    np.testing.assert_allclose(far, [0.0, 1.1, -1.1])


def test_bad_parameters():
    rows = [
        ({"operator": "slide"}, "operator is 'slide': use 'stop' or 'play'"),
        ({"stiffness": "big"}, "stiffness is 'big': give a number"),
        ({"stiffness": True}, "stiffness is True: give a number"),
        ({"rest_angle": math.nan}, "rest_angle is nan: give a finite number"),
        ({"weights": [5.0]}, "1 weights for 2 thresholds: give one weight for each"),
        ({"weights": [5.0, math.inf]}, r"weights\[1\] is inf: give finite numbers"),
        ({"weights": 5.0}, "weights is 5.0: give at least one number"),
        ({"weights": [[5.0], 2.0]}, "weights is .*: give at least one number"),
        ({"thresholds": [], "weights": []}, r"thresholds is \[\]: give at least one number"),
        ({"thresholds": ["0.1", "0.3"]}, "thresholds is .*: give at least one number"),
        ({"thresholds": [0.0, 0.3]}, r"thresholds\[0\] is 0.0 rad: it must be above 0.0;"),
        ({"thresholds": [0.3, 0.3]}, r"thresholds\[1\] is 0.3 rad: it must be above 0.3;"),
    ]
    assert_refused(lambda change: simple(**change), rows)


def test_a_torque_that_no_first_loading_has():
    with pytest.raises(InputError, match=r"0 N·m at 1.2 rad: .* 0.4 to 1.6 .*; give a torque"):
        simple(weights=[3.0, 1.0]).start(1.2)
