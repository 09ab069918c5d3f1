"""The Bouc-Wen fit: known models come back, unseen curves are predicted, all of it certified."""

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import BoucWen
from activesuit.identification import Curve
from activesuit.identification.fits.bouc_wen import fit_bouc_wen
from helpers import sweep

START, TURNS, UNSEEN = 0.52, (0.87, 1.22, 1.57), (0.75, 1.05, 1.4)
SOFTENING = BoucWen(elastic=2.0, hysteretic=15.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=START)
PRELOADED = BoucWen(elastic=2.0, hysteretic=15.0, beta=20.0, gamma=-8.0, n=2.5, rest_angle=0.2)
EXPONENTIAL = BoucWen(elastic=-1.0, hysteretic=9.0, beta=6.0, gamma=0.0, n=1.0, rest_angle=0.5)
TRUTHS = {"softening": SOFTENING, "preloaded": PRELOADED, "exponential": EXPONENTIAL}


def family(model, turns=TURNS, first_torque=0.0, noise=0.0, seed=0, role="fit"):
    rng = np.random.default_rng(seed)
    curves = []
    for turn in turns:
        angle = sweep(START, turn, START, samples=60)
        torque = model.response(angle, first_torque) + noise * rng.standard_normal(angle.size)
        curves.append(Curve(angle, torque, f"{turn}", role))
    return curves


def rms(model, curves, first_torque=0.0):
    errors = [model.response(curve.angle, first_torque) - curve.torque for curve in curves]
    return np.sqrt(np.mean(np.concatenate(errors) ** 2))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", TRUTHS)
def test_a_known_model_comes_back(name, seed):
    known = TRUTHS[name]
    found = fit_bouc_wen(family(known), seed)
    for parameter in ("elastic", "hysteretic", "beta", "gamma", "n", "rest_angle"):
        expected = getattr(known, parameter)
        assert getattr(found, parameter) == pytest.approx(expected, rel=1e-3, abs=1e-3)
    assert found.A == 1


def test_a_first_torque_comes_back():
    found = fit_bouc_wen(family(PRELOADED, first_torque=0.7), 0)
    unseen = family(PRELOADED, UNSEEN, first_torque=0.7)
    assert rms(found, unseen, first_torque=0.7) < 1e-4


@pytest.mark.parametrize("name", TRUTHS)
def test_unseen_curves_are_predicted_under_noise(name):
    known = TRUTHS[name]
    peak = max(np.abs(curve.torque).max() for curve in family(known))
    for seed in range(10):
        found = fit_bouc_wen(family(known, noise=0.01 * peak, seed=seed), seed)
        assert rms(found, family(known, UNSEEN)) < 0.005 * peak
        certificate = found.certificate()
        assert certificate.certified
        assert certificate.dissipative


def test_only_certified_models_are_returned(elbow):
    # Not a Bouc-Wen curve, and one that feeds energy into the joint.
    driven = [Curve(c.angle, -c.torque, c.name) for c in family(SOFTENING)]
    for curves in (family(elbow), driven):
        found = fit_bouc_wen(curves, 0)
        assert found.certificate().certified
        assert found.certificate().dissipative
        assert found.start_is_certified(found.start(START, 0.0))


def test_a_seed_fixes_the_result_and_other_roles_do_not_count():
    curves = family(SOFTENING, noise=0.02)
    wrong = family(SOFTENING, UNSEEN, noise=5.0, role="predict")
    assert fit_bouc_wen(curves, 3) == fit_bouc_wen([*curves, *wrong], 3)


def test_bad_input():
    curves = family(SOFTENING)
    apart = Curve(curves[0].angle + 0.3, curves[0].torque, "apart")
    with pytest.raises(InputError, match=r"the curves begin at 0.52 to 0.82 rad"):
        fit_bouc_wen([*curves, apart])
    with pytest.raises(InputError, match="budget is 10: use at least 65"):
        fit_bouc_wen(curves, budget=10)
    with pytest.raises(InputError, match="there is no curve to fit"):
        fit_bouc_wen(family(SOFTENING, role="predict"))
    short = Curve([0.5, 0.6, 0.7, 0.6, 0.5], [0, 1, 2, 0, -1], "short")
    with pytest.raises(InputError, match="samples at 3 different angles: give at least 8"):
        fit_bouc_wen([short])
