"""Promises of every certified fit: known models come back, and only safe ones are returned."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.hysteresis import MODELS, BoucWen, Dahl, Duhem
from activesuit.identification import Curve, fit_curves
from activesuit.identification.fits.objective import torque_errors
from activesuit.identification.fits.registry import FITS, fit_model
from helpers import assert_refused, family, is_safe, sweep

START, UNSEEN = 0.52, (0.75, 1.05, 1.4)
SPRING = (-0.6, 2.0, -1.0, 0.8)
TRUTH = BoucWen(elastic=2.0, hysteretic=15.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=START)
TRUTHS = {
    "softening": TRUTH,
    "preloaded": replace(TRUTH, gamma=-8.0, n=2.5, rest_angle=0.2),
    "exponential": BoucWen(elastic=-1, hysteretic=9, beta=6, gamma=0, n=1, rest_angle=0.5),
    "dahl": Dahl(spring=SPRING, stiffness=12.0, friction=1.5),
    "duhem": Duhem(spring=SPRING, stiffness=12.0, friction_up=2.0, friction_down=0.6),
}
BENT = [Curve(sweep(0.5, 1.0, 0.5, samples=9), np.sin(np.arange(17)), "bent")]


def begun(model, z=0.0):
    """The torque [N·m] at the beginning with a friction of z."""
    return z + (np.polynomial.polynomial.polyval(START, SPRING) if hasattr(model, "spring") else 0)


def numbers(model):
    return [one for value in list(model.to_dict().values())[1:] for one in np.atleast_1d(value)]


LOADED = [(name, z) for name in ("dahl", "duhem") for z in (-0.55, 1.4)]


@pytest.mark.parametrize(("name", "z"), [*((name, 0.0) for name in TRUTHS), *LOADED])
def test_a_known_model_comes_back(name, z):
    known, limit = TRUTHS[name], 2e-4 if name in ("dahl", "duhem") else 1e-3
    for seed in range(5):
        found = FITS[known.name](family(known, first=begun(known, z)), rng=seed)
        np.testing.assert_allclose(numbers(found), numbers(known), rtol=limit, atol=limit)


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=pytest.mark.slow if "d" in one[:2] else ()) for one in TRUTHS]
)
def test_unseen_curves_are_predicted_under_noise(name):
    known = TRUTHS[name]
    first, unseen = begun(known), family(known, UNSEEN, first=begun(known))
    noise = 0.01 * max(np.abs(curve.torque).max() for curve in family(known, first=first))
    for seed in range(10):
        curves = family(known, first=first, noise=noise, seed=seed)
        found = fit_model(known.name, curves, np.random.default_rng(seed))
        error = torque_errors(found.model, found.initial_torque, unseen)
        assert np.sqrt(np.mean(error**2)) < 0.5 * noise


def fitted(name, curves):
    return fit_model(name, curves, np.random.default_rng(3))


@pytest.mark.parametrize("name", FITS)
def test_every_model_is_identified_safely(small_family, name):
    loaded = [Curve(c.angle, c.torque + 0.4, c.name, c.role) for c in small_family]
    option = {"initial_torque": "identified"} if name == "jiles-atherton" else {}
    fit = fit_curves(loaded, model=name, **option)
    assert fit.model_name == name
    assert name in MODELS
    assert fit.nrmse < 0.03
    assert fit.initial_torque == pytest.approx(0.4, abs=0.15)
    assert is_safe(fit.model)
    assert fit.model.start_is_certified(fit.model.start(0.52, fit.initial_torque))
    (kept,) = [curve for curve in loaded if curve.role == "predict"]
    error = np.abs(fit.predict(kept) - kept.torque).max()
    assert fit.prediction_errors == {kept.name: error}
    assert fit_curves(loaded, model=name, workers=1, **option) == fit


@pytest.mark.parametrize("name", FITS)
def test_a_seed_fixes_the_result_and_other_roles_do_not_count(name):
    curves = family(TRUTH, noise=0.02)
    wrong = family(TRUTH, (0.75, 1.05), noise=5.0, role="predict")
    if name == "jiles-atherton":  # whose fit takes what it gets
        one, two = (fit_curves(some, seed=3) for some in (curves, [*curves, *wrong]))
        assert one.model == two.model
    else:
        assert fitted(name, curves).model == fitted(name, [*curves, *wrong]).model


@pytest.mark.parametrize("name", FITS)
def test_only_certified_models_are_returned(elbow, name):
    """Also of curves of another kind, and of some that feed energy into the joint."""
    driven = [Curve(c.angle, -c.torque, c.name) for c in family(TRUTH)]
    cannot_begin = ("prandtl-ishlinskii", "hinged-stops")  # as driven curves do
    for curves in (family(elbow), *([] if name in cannot_begin else [driven])):
        assert is_safe(fitted(name, curves).model, (0.52, 1.57))


@pytest.mark.parametrize("name", FITS)
def test_unusable_families(name):
    turning, up = sweep(0.5, 1.0, 0.5), np.linspace(0.5, 1, 50)
    tiny = [Curve(c.angle, 1e-300 * c.torque, c.name) for c in family(TRUTH)]
    rows = [
        ([], "no curve to fit"),
        (family(TRUTH, role="predict"), "no curve to fit|no curve with role"),
        (tiny, r"peaks at .*e-300 N·m: give at least 1e-09 N·m; check"),
        ([Curve(up, 2 * up, "up")], "no curve turns back"),
        ([Curve(turning, 0 * turning, "flat")], "every torque is zero|no torque changes"),
    ]
    if name not in ("jiles-atherton", "preisach"):
        apart = family(TRUTH, (1.5,), start=0.82)
        rows.append(([*family(TRUTH), *apart], "the curves begin at 0.52 to 0.82 rad"))
    assert_refused(lambda curves: fit_curves(curves, model=name), rows)


def test_bad_options():
    curves = family(TRUTH)
    short = [Curve([0.5, 0.6, 0.7, 0.6, 0.5], [0, 1, 2, 0, -1], "short")]
    rows = [
        ("jiles-atherton", curves, {"initial_torque": "guessed"}, "guessed"),
        ("jiles-atherton", curves, {"initial_torque": np.nan}, "nan"),
        ("jiles-atherton", curves, {"budget": 32}, "budget is 32: use at least 33"),
        ("bouc-wen", curves, {"budget": 10}, "budget is 10: use at least 65"),
        ("bouc-wen", short, {}, "samples at 3 different angles: give at least 8"),
        ("asymmetric", curves, {"degree": 0}, "degree is 0: use 1 to 5"),
        ("asymmetric", curves, {"degree": 6}, "degree is 6: use 1 to 5"),
        ("dahl", curves, {"degree": 0}, "degree is 0: use at least 1"),
        ("dahl", curves, {"degree": 6}, "degree is 6: use at most 5"),
        ("dahl", curves, {"budget": 8}, "budget is 8: use at least 9"),
        ("preisach", BENT, {"levels": 1}, "levels is 1: use at least 2"),
        ("preisach", BENT, {"levels": 0.5}, "levels is 0.5: give at least one number"),
        ("preisach", BENT, {"levels": [1.0]}, "give at least 2 angles"),
        ("preisach", BENT, {"levels": [0.6, 0.5, 0.9]}, r"levels is \(0\.6, 0\.5, 0\.9\) rad"),
        ("preisach", BENT, {"levels": [2.0, 3.0]}, "from 2 to 3 rad and the curves from 0.5 to"),
        ("prandtl-ishlinskii", BENT, {"thresholds": 0}, "thresholds is 0: use at least 1"),
        ("prandtl-ishlinskii", BENT, {"thresholds": [0.1, -0.2]}, "increasing numbers above 0"),
        ("prandtl-ishlinskii", BENT, {"thresholds": [0.2, 0.1]}, "increasing numbers above 0"),
        ("prandtl-ishlinskii", BENT, {"thresholds": []}, "give at least one number"),
        ("hinged-stops", curves, {"thresholds": 0}, "thresholds is .*: use"),
        ("hinged-stops", curves, {"thresholds": 2.5}, "thresholds is .*: use"),
        ("hinged-stops", curves, {"thresholds": True}, "thresholds is .*: use"),
        ("hinged-stops", curves, {"thresholds": [0.1]}, "thresholds is .*: use"),
    ]
    assert_refused(lambda name, given, options: FITS[name](given, **options), rows)
