"""The Bouc-Wen model against its equation, closed forms, and other ways to write it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from activesuit.benchmarks.references import integrate, reference_of
from activesuit.errors import InputError
from activesuit.hysteresis import PoleError
from activesuit.hysteresis.bouc_wen.model import BoucWen
from helpers import assert_refused, sweep
from known_models import ledger

POWERS = (1.0, 1.05, 1.5, 2.0, 3.7, 20.0)
SHAPES = ((3, 2), (3, -2), (2, 2), (2, -2), (1, 3))  # beta, gamma
PARAMETERS = {"elastic": 0.7, "hysteretic": 2.0, "beta": 3.0, "gamma": 1.0, "n": 1.5}


def model(**changes) -> BoucWen:
    return BoucWen(**{**PARAMETERS, **changes})


def test_agrees_with_the_equation():
    for n in POWERS:
        rng = np.random.default_rng(int(10 * n))
        for beta, gamma in SHAPES:
            m = model(beta=beta, gamma=gamma, n=n, A=1.3, rest_angle=0.1)
            turns = np.cumsum(rng.normal(0, 0.6, 6))
            torque = m.elastic * (turns[0] - m.rest_angle) + m.hysteretic * 0.2
            expected = integrate(reference_of(m, turns, torque), turns, 1e-12)
            np.testing.assert_allclose(m.response(turns, torque), expected, atol=1e-8)
            fine = sweep(*turns, samples=2000)
            work = np.trapezoid(m.response(fine, torque), fine)
            stored, dissipated = ledger(m, turns, torque)
            change = stored[-1] - stored[0] + dissipated[-1]
            assert change == pytest.approx(work, rel=1e-4, abs=1e-5)


def test_closed_forms():
    x = np.linspace(0, 4, 33)[1:]
    ends = {"elastic": 0.0, "hysteretic": 1.0}

    def jump(m, start=0.0, sign=1.0):
        return np.array([m.response([0.0, sign * angle], start)[-1] for angle in x])

    np.testing.assert_allclose(jump(model(n=1, **ends)), (1 - np.exp(-4 * x)) / 4, rtol=1e-13)
    np.testing.assert_allclose(jump(model(n=2, **ends)), np.tanh(2 * x) / 2, rtol=1e-12)
    # Hardening: beta + gamma = -4; unloading: beta - gamma = 4 from 0.5, until z = 0.
    hard = model(n=2, beta=0, gamma=-4, **ends)
    near = x[x < math.pi / 4 - 0.01]
    torque = [hard.response([0.0, a])[-1] for a in near]
    np.testing.assert_allclose(torque, np.tan(2 * near) / 2, rtol=1e-11)
    soft = model(n=2, beta=4, gamma=0, **ends)
    passed = math.atan(1.0) / 2
    expected = np.where(
        x < passed, np.tan(np.minimum(2 * (passed - x), 1)) / 2, -np.tanh(2 * (x - passed)) / 2
    )
    np.testing.assert_allclose(jump(soft, 0.5, -1.0), expected, atol=1e-13)
    straight = model(beta=1, gamma=1, **ends)  # unloading without a curve
    assert straight.response([0.0, -0.3], 0.4)[-1] == pytest.approx(0.1, rel=1e-14)


def test_tiny_and_huge_steps():
    for n in POWERS:
        m = model(n=n, elastic=0)
        for torque in (0.4, -0.4, 0.0):
            here = m.start(0.8, torque)
            _, after = m.step(here, 0.8 + 1e-12)
            moved = (0.8 + 1e-12) - 0.8
            assert after == pytest.approx(torque + moved * m.tangent(here, 1), abs=1e-16)
        bound = m.hysteretic * m.z_bound
        for angle in (1e3, -1e9, 1e300):
            end = math.copysign(bound, angle)
            assert m.response([0.0, angle])[-1] == pytest.approx(end, rel=1e-13)


def test_a_start_far_outside_saturation_comes_back():
    m = model(n=3, elastic=0, hysteretic=1)
    # dz/dtheta = -(beta + gamma) z^3 but for 1e-27 of it, then saturation.
    torque = m.response([0.0, 1e-4, 10.0], 1e9)
    assert torque[1] == pytest.approx(1 / math.sqrt(2 * 4 * 1e-4), rel=1e-3)
    assert torque[2] == pytest.approx(m.z_bound, rel=1e-13)
    assert not m.start_is_certified(m.start(0.0, 1e9))


def test_a_torque_that_no_angle_has():
    with pytest.raises(InputError, match=r"torque\[1\] is 9 .*reaches it"):
        model(elastic=0.0).inverse([0.0, 9.0])


def test_poles_are_found_where_they_are():
    hard = model(n=2, beta=1, gamma=-5, elastic=0)  # z = tan(2 theta) / 2
    assert hard.certificate().margin == pytest.approx(-4 / 6)
    assert hard.response([0.0, math.pi / 4 * (1 - 1e-9)])[-1] > 1e8
    for angle in (math.pi / 4 * (1 + 1e-9), 1e9):
        with pytest.raises(PoleError, match=r"margin is -0\.667"):
            hard.response([0.0, angle])
    # beta < 0: unloading from saturation diverges.
    active = model(n=3, beta=-1, gamma=2)
    assert active.certificate().margin < 0
    with pytest.raises(PoleError, match=r"sample 2"):
        active.response([0.0, 5.0, -5.0])
    with pytest.raises(PoleError):
        active.step(active.start(0.0, 2.8), -5.0)
    assert math.isinf(model(n=1, beta=1, gamma=-5).certificate().memory_bound)
    assert model(n=1, beta=1, gamma=-5).response([0.0, 1.0])[-1] < math.inf


def test_certificate():
    certificate = model(n=2).certificate((-0.5, 1.0))
    assert (certificate.margin, certificate.dissipative) == (1.0, True)
    assert certificate.memory_bound == pytest.approx(2 * math.sqrt(1 / 4))
    assert certificate.torque_bound == pytest.approx(0.7 + certificate.memory_bound)
    assert math.isinf(model().certificate().torque_bound)
    assert math.isfinite(model(elastic=0).certificate().torque_bound)
    for gamma, dissipative in ((3.0, True), (-3.0, True), (3.01, False), (-3.01, False)):
        assert model(gamma=gamma).certificate().dissipative == dissipative
        assert not model(gamma=gamma, hysteretic=-2).certificate().dissipative
    assert model(beta=-3, hysteretic=-2).certificate().dissipative
    assert math.isinf(model(n=1, beta=-1, gamma=2).z_bound)
    m = model()
    saturated, _ = m.step(m.start(0.0), 1e4)
    assert m.start_is_certified(saturated)


def test_A_is_a_scale():
    angle = sweep(0.1, 0.8, -0.4, 0.3, samples=9)
    m, shape = model(A=1.7, gamma=-2.0, n=2.3, rest_angle=0.1), 1.7**1.3
    same = replace(
        m, A=1.0, hysteretic=1.7 * m.hysteretic, beta=shape * m.beta, gamma=shape * m.gamma
    )
    np.testing.assert_allclose(same.response(angle), m.response(angle), atol=1e-12)


def test_bad_parameters():
    rows = [
        ({"hysteretic": 0}, r"hysteretic is 0\.0 N·m/rad: give a number other than 0"),
        ({"A": -1}, "A is -1.0: give a number above 0"),
        ({"n": 0.5}, r"n is 0\.5: give a number from 1 to 1e6"),
        ({"n": 1e7}, "n is 10000000"),
        ({"beta": math.nan}, "beta is nan: give a finite number"),
        ({"gamma": "x"}, "gamma is 'x': give a number"),
        ({"elastic": True}, "elastic is True: give a number"),
    ]
    assert_refused(lambda changes: model(**changes), rows)
