"""The Bouc-Wen fit: known models come back, unseen curves are predicted, all of it certified."""

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import BoucWen
from activesuit.identification import Curve
from activesuit.identification.fits.bouc_wen import fit_bouc_wen
from helpers import family

START, UNSEEN = 0.52, (0.75, 1.05, 1.4)
SOFTENING = BoucWen(elastic=2.0, hysteretic=15.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=START)
PRELOADED = BoucWen(elastic=2.0, hysteretic=15.0, beta=20.0, gamma=-8.0, n=2.5, rest_angle=0.2)
EXPONENTIAL = BoucWen(elastic=-1.0, hysteretic=9.0, beta=6.0, gamma=0.0, n=1.0, rest_angle=0.5)
TRUTHS = {"softening": SOFTENING, "preloaded": PRELOADED, "exponential": EXPONENTIAL}


def rms(model, curves, first_torque=0.0):
    errors = [model.response(curve.angle, first_torque) - curve.torque for curve in curves]
    return np.sqrt(np.mean(np.concatenate(errors) ** 2))


def test_a_known_model_comes_back():
    for known in TRUTHS.values():
        for seed in range(5):
            found = fit_bouc_wen(family(known), seed)
            for parameter in ("elastic", "hysteretic", "beta", "gamma", "n", "rest_angle"):
                expected = getattr(known, parameter)
                assert getattr(found, parameter) == pytest.approx(expected, rel=1e-3, abs=1e-3)
            assert found.A == 1


def test_a_first_torque_comes_back():
    found = fit_bouc_wen(family(PRELOADED, first=0.7), 0)
    unseen = family(PRELOADED, UNSEEN, first=0.7)
    assert rms(found, unseen, first_torque=0.7) < 1e-4


def test_unseen_curves_are_predicted_under_noise():
    for known in TRUTHS.values():
        peak = max(np.abs(curve.torque).max() for curve in family(known))
        for seed in range(10):
            found = fit_bouc_wen(family(known, noise=0.01 * peak, seed=seed), seed)
            assert rms(found, family(known, UNSEEN)) < 0.005 * peak


def test_bad_input():
    with pytest.raises(InputError, match="budget is 10: use at least 65"):
        fit_bouc_wen(family(SOFTENING), budget=10)
    short = Curve([0.5, 0.6, 0.7, 0.6, 0.5], [0, 1, 2, 0, -1], "short")
    with pytest.raises(InputError, match="samples at 3 different angles: give at least 8"):
        fit_bouc_wen([short])
