"""The model against MuJoCo's own plastic springs; loops and branches; its inverse."""

import math

import mujoco
import numpy as np
import pytest
from activesuit.benchmarks.references import PrandtlIshlinskiiReference
from activesuit.hysteresis.stops import PrandtlIshlinskii
from helpers import assert_refused, sweep
from hypothesis import strategies as st
from stop_models import angles, for_any, paths, stops


def reference(model, angle):
    """The readable model, at rest at an angle."""
    return PrandtlIshlinskiiReference(model, np.array([angle]), 0.0)


def simple(**change):
    values = {"stiffness": 1.0, "thresholds": [0.1, 0.3], "weights": [5.0, 2.0], "rest_angle": 0.2}
    return PrandtlIshlinskii(**{**values, **change})


def response(model, path):
    """The torque along a path that begins with all stops at zero."""
    return model.response(path, reference(model, path[0]).torque)


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
    far = simple(stiffness=0.0).response([0.2, 1e300, -1e300])
    np.testing.assert_allclose(far, [0.0, 1.1, -1.1])


@for_any(stops(), paths, paths, angles, angles)
def test_loops_between_the_same_angles_are_congruent(model, one, other, low, high):
    loop = sweep(low, high, low, samples=20)
    one = response(model, [*one, low, high, *loop])[-loop.size :]
    other = response(model, [*other, low, high, *loop])[-loop.size :]
    assert one[-1] == one[0]
    np.testing.assert_allclose(one - one[0], other - other[0], atol=1e-11)


@for_any(stops(), st.floats(-2, 2), st.floats(0, 2))
def test_branches_are_the_first_loading_twice_as_large(model, peak, part):
    rest = model.rest_angle
    torque = model.response([rest, rest + peak, rest + peak - part * peak])
    _, half = model.response([rest, rest + part * peak / 2])
    assert torque[2] == pytest.approx(torque[1] - 2 * half, abs=1e-11)


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
