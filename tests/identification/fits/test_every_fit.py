"""Promises of every certified fit, tested in the same way for each."""

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.hysteresis import MODELS, BoucWen
from activesuit.identification import Curve, identify
from activesuit.identification.fits.registry import FITS, fit_model
from helpers import family, sweep

TRUTH = BoucWen(elastic=2.0, hysteretic=15.0, beta=20.0, gamma=8.0, n=1.5, rest_angle=0.52)


def fitted(name, curves):
    return fit_model(name, curves, np.random.default_rng(3))


@pytest.mark.parametrize("name", FITS)
def test_every_model_is_identified_safely(small_family, name):
    loaded = [Curve(c.angle, c.torque + 0.4, c.name, c.role) for c in small_family]
    option = {"initial_torque": "identified"} if name == "jiles-atherton" else {}
    fit = identify(loaded, model=name, **option)
    assert fit.model_name == name
    assert name in MODELS
    assert fit.nrmse < 0.03
    assert fit.initial_torque == pytest.approx(0.4, abs=0.15)
    assert fit.model.certificate().certified
    assert fit.model.certificate().dissipative
    assert fit.model.start_is_certified(fit.model.start(0.52, fit.initial_torque))
    (kept,) = [curve for curve in loaded if curve.role == "predict"]
    error = np.abs(fit.predict(kept) - kept.torque).max()
    assert fit.prediction_errors == {kept.name: error}
    assert identify(loaded, model=name, workers=1, **option) == fit


@pytest.mark.parametrize("name", FITS)
def test_a_seed_fixes_the_result_and_other_roles_do_not_count(name):
    curves = family(TRUTH, noise=0.02)
    wrong = family(TRUTH, (0.75, 1.05), noise=5.0, role="predict")
    if name == "jiles-atherton":  # whose fit takes what it gets
        one, two = (identify(some, seed=3) for some in (curves, [*curves, *wrong]))
        assert one.model == two.model
    else:
        assert fitted(name, curves).model == fitted(name, [*curves, *wrong]).model


@pytest.mark.parametrize("name", FITS)
def test_only_certified_models_are_returned(elbow, name):
    """Also of curves of another kind, and of some that feed energy into the joint."""
    driven = [Curve(c.angle, -c.torque, c.name) for c in family(TRUTH)]
    cannot_begin = ("prandtl-ishlinskii", "hinged-stops")  # as driven curves do
    for curves in (family(elbow), *([] if name in cannot_begin else [driven])):
        found = fitted(name, curves).model
        assert found.certificate((0.52, 1.57)).certified
        assert found.certificate((0.52, 1.57)).dissipative


@pytest.mark.parametrize("name", FITS)
def test_unusable_families(name):
    turning, up = sweep(0.5, 1.0, 0.5), np.linspace(0.5, 1, 50)
    tiny = [Curve(c.angle, 1e-300 * c.torque, c.name) for c in family(TRUTH)]
    wrong = {
        "no curve to fit": [],
        "no curve to fit|no curve with role": family(TRUTH, role="predict"),
        r"peaks at .*e-300 N·m: give at least 1e-09 N·m; check": tiny,
        "no curve turns back": [Curve(up, 2 * up, "up")],
        "every torque is zero|no torque changes": [Curve(turning, 0 * turning, "flat")],
    }
    if name not in ("jiles-atherton", "preisach"):
        apart = family(TRUTH, (1.5,), start=0.82)
        wrong["the curves begin at 0.52 to 0.82 rad"] = [*family(TRUTH), *apart]
    for words, curves in wrong.items():
        with pytest.raises(InputError, match=words):
            identify(curves, model=name)
