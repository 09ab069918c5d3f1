"""Direct fits: known models come back, other curves are predicted, and bad families are refused."""

import numpy as np
import pytest
from activesuit.hysteresis.preisach.model import Preisach
from activesuit.hysteresis.stops import PrandtlIshlinskii
from activesuit.identification import Curve
from activesuit.identification.fits.weights import fit_prandtl_ishlinskii, fit_preisach
from helpers import family, sweep

START, TURNS = 0.5, (0.7, 0.9, 1.1, 1.3, 1.5)
LEVELS = [0.3, *np.arange(0.5, 1.51, 0.2)]
PATH = sweep(0.5, 1.5, 0.7, 1.2, 0.9, 1.4, 0.5, samples=50)


def known_preisach():
    rng = np.random.default_rng(0)
    density = [rng.uniform(0, 1, i + 1) for i in range(6)]
    return Preisach(levels=LEVELS, density=density, elastic=rng.uniform(5, 20, 6))


def known_stops(rest_angle=START):
    stops = {"thresholds": [0.05, 0.1, 0.2, 0.35], "weights": [20.0, 8.0, 0.0, 5.0]}
    return PrandtlIshlinskii(stiffness=2.0, **stops, rest_angle=rest_angle)


def curves_of(model, turns=TURNS, **options):
    return family(model, turns, start=START, samples=80, **options)


def test_a_known_preisach_model_comes_back():
    known = known_preisach()
    found = fit_preisach(curves_of(known, first=0.3), LEVELS)
    np.testing.assert_allclose(found.response(PATH), known.response(PATH), atol=1e-6)
    for row, expected in zip(found.density[1:], known.density[1:], strict=True):
        np.testing.assert_allclose(row, expected, atol=1e-5)
    np.testing.assert_allclose(found.elastic[1:], known.elastic[1:], atol=1e-5)


def test_a_known_stops_model_comes_back():
    known = known_stops(rest_angle=0.4)
    first = 2.0 * (START - 0.4)
    found = fit_prandtl_ishlinskii(curves_of(known, first=first), known.thresholds)
    np.testing.assert_allclose(found.weights, known.weights, atol=1e-9)
    assert found.rest_angle == pytest.approx(0.4, abs=1e-9)
    np.testing.assert_allclose(found.response(PATH, first), known.response(PATH, first), atol=1e-9)


def test_held_out_curves_are_predicted_under_noise(elbow):
    for fit, detail, name in [
        (fit_preisach, LEVELS, "preisach"),
        (fit_preisach, 20, "elbow"),
        (fit_prandtl_ishlinskii, 20, "stops"),
    ]:
        for seed in range(4):
            known = {"preisach": known_preisach(), "stops": known_stops(), "elbow": elbow}[name]
            held_out = curves_of(known, (0.8, 1.0, 1.2, 1.4), role="predict")
            wrong = Curve(held_out[0].angle, -held_out[0].torque, "wrong, not fitted", "predict")
            peak = max(np.abs(curve.torque).max() for curve in held_out)
            found = fit([*curves_of(known, noise=0.01 * peak, seed=seed), *held_out, wrong], detail)
            assert found.certificate().dissipative
            for curve in held_out:
                error = found.response(curve.angle) - curve.torque
                assert np.sqrt(np.mean(error**2)) < 0.01 * peak


def test_an_offset_of_a_curve_changes_nothing():
    curves = curves_of(known_preisach())
    shifted = [Curve(c.angle, c.torque + 0.1 * i, c.name) for i, c in enumerate(curves)]
    one, two = fit_preisach(curves, LEVELS), fit_preisach(shifted, LEVELS)
    np.testing.assert_allclose(one.response(PATH), two.response(PATH), atol=1e-6)


def test_a_level_below_the_start_keeps_a_first_loop_open(elbow):
    curves = curves_of(elbow)
    closed = fit_preisach(curves, np.linspace(START, 1.5, 20))
    found = fit_preisach(curves, 20)
    assert found.levels[0] < START == pytest.approx(found.levels[1])
    for curve in curves:
        assert closed.response(curve.angle)[-1] == pytest.approx(0, abs=1e-12)
        assert found.response(curve.angle)[-1] == pytest.approx(curve.torque[-1], abs=0.02)


def test_what_no_curve_tells_is_smooth():
    # Between the two turns, and beyond the last, the data say nothing about single cells.
    found = fit_preisach(curves_of(known_stops(), (0.9, 1.3)), [*np.linspace(0.4, 1.3, 10), 3.0])
    assert np.isfinite(found.response(sweep(0.5, 2.9, 0.5))).all()
    assert found.elastic[-1] == pytest.approx(found.elastic[-2], rel=0.2)
