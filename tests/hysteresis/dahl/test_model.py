"""Dahl's friction and the Duhem model: exact solution, energy, unlike ways."""

import math

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import BoucWen, Dahl, Duhem, model_from_dict
from activesuit.hysteresis.dahl import kernels
from helpers import assert_refused, sweep
from known_models import ledger
from scipy.integrate import quad

SPRING = (1.0, 2.0, -3.0, 1.5)
DAHL = Dahl(spring=SPRING, stiffness=30.0, friction=2.0)
DUHEM = Duhem(spring=SPRING, stiffness=30.0, friction_up=2.0, friction_down=0.7)
NO_SPRING = Duhem(spring=(0.0,), stiffness=3.0, friction_up=2.0, friction_down=0.5)


def spring(angle):
    return np.polynomial.polynomial.polyval(angle, SPRING)


def test_dahl_is_duhem_with_equal_frictions_and_bouc_wen_with_a_straight_spring():
    twin = Duhem(spring=SPRING, stiffness=30.0, friction_up=2.0, friction_down=2.0)
    angle = sweep(0.2, 1.3, 0.5, 0.9, 0.1)
    np.testing.assert_array_equal(DAHL.response(angle), twin.response(angle))
    straight = Dahl(spring=(-0.3, 1.5), stiffness=8.0, friction=2.0)
    wen = BoucWen(elastic=1.5, hysteretic=8.0, beta=4.0, gamma=0.0, n=1.0, rest_angle=0.2)
    np.testing.assert_allclose(straight.response(angle), wen.response(angle), atol=1e-12)


def test_loss_and_torque_have_all_digits_in_tiny_and_huge_steps():
    for step in [1e-12, 1e-6, 0.0333, 0.0334, 1.0, 40.0]:
        for z in [0.0, 1.0, -0.5, 1.999999, 7.0, -7.0]:
            for sign, F in ((1, 2.0), (-1, 0.5)):
                _, after = NO_SPRING.step(NO_SPRING.start(0.0, z), sign * step)
                x = 3.0 * step / F
                end = sign * F + (z - sign * F) * math.exp(-x)
                assert after == pytest.approx(end, rel=1e-9, abs=1e-15)
                if x < 1e-5:
                    change = after - z
                    assert change == pytest.approx(3.0 * (sign - z / F) * step, rel=1e-4, abs=1e-15)

                def rate(tau, F=F, w=sign * z / F):
                    return F * (w - (w - 1) * -math.expm1(-3.0 * tau / F)) ** 2

                expected = quad(rate, 0, step, epsabs=0, epsrel=1e-11)[0]
                p, s = NO_SPRING.parameter_vector.copy(), NO_SPRING.start(0.0, z).memory.copy()
                _, loss, _ = kernels.move(p, s, sign * step)
                assert loss == pytest.approx(expected, rel=1e-10)


def test_a_start_outside_the_limits_comes_back_and_loses_energy():
    angle = np.linspace(0, 5, 100)
    torque = NO_SPRING.response(angle, 9.0)
    assert (np.diff(torque) < 0).all()
    assert torque[-1] == pytest.approx(2.0, abs=0.01)
    _, dissipated = ledger(NO_SPRING, angle, 9.0)
    assert (np.diff(dissipated) > 0).all()
    for start, safe in ((9.0, False), (-0.6, False), (2.0, True), (-0.5, True), (0.0, True)):
        assert NO_SPRING.start_is_certified(NO_SPRING.start(0.0, start)) == safe


def test_certificate():
    certificate = DUHEM.certificate((-0.5, 1.0))
    assert (certificate.margin, certificate.dissipative) == (1.0, True)
    assert certificate.memory_bound == 0.7
    inside = spring(np.linspace(-0.5, 1, 10_001))
    assert certificate.torque_bound == pytest.approx(max(inside.max() + 2.0, 0.7 - inside.min()))
    assert math.isinf(DUHEM.certificate().torque_bound)
    assert NO_SPRING.certificate().torque_bound == 2.0


def test_bad_parameters():
    good = {"spring": [1.0, 2.0], "stiffness": 30.0, "friction_up": 2.0, "friction_down": 1.0}
    rows = [
        ({"spring": []}, r"spring is \[\]: give at least one number \(N·m/rad\^i\)"),
        ({"spring": [1, math.nan]}, r"spring\[1\] is nan: give finite numbers"),
        ({"spring": [0] * 7}, r"spring is \(0.*\) N·m/rad\^i: give 1 to 6 coefficients"),
        ({"spring": 1.0}, r"spring is 1.0: give at least one number"),
        ({"stiffness": 0}, r"stiffness is 0\.0 N·m/rad: give a number above 0"),
        ({"stiffness": math.inf}, "stiffness is inf: give a finite number"),
        ({"friction_up": -1}, r"friction_up is -1\.0 N·m: give a number above 0"),
        ({"friction_down": "a"}, "friction_down is 'a': give a number"),
    ]
    assert_refused(lambda changes: Duhem(**{**good, **changes}), rows)
    assert_refused(lambda changes: model_from_dict({"model": "duhem", **good, **changes}), rows)
    with pytest.raises(InputError, match=r"friction is 0\.0 N·m: give a number above 0"):
        Dahl(spring=(0.0,), stiffness=1.0, friction=0)
