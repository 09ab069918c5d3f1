"""The offset of the torque sensor."""

from dataclasses import replace

import helpers
import numpy as np
import pytest
from activesuit.identification import Corrections, Curve, identify, select
from activesuit.identification.figures import loops_figure
from helpers import sweep

OFFSET, NOISE = 1.3, 0.05


def family(model, offset=OFFSET, noise=NOISE):
    curves = helpers.family(model, noise=noise, seed=2, samples=200)
    return [replace(one, torque=one.torque + offset) for one in curves]


@pytest.mark.parametrize(
    "tare", ["fit", *(pytest.param(one, marks=pytest.mark.slow) for one in (OFFSET, "zero"))]
)
def test_the_offset_is_taken_off(elbow, tare):
    fit = identify(family(elbow), corrections=Corrections(tare=tare))
    assert fit.tare == pytest.approx(OFFSET, abs=0.15 if tare == "zero" else 0.03)
    assert fit.judgement.causes == () or tare == "zero"
    assert fit.nrmse * 7 < 1.6 * NOISE
    np.testing.assert_allclose(fit.curves[0].torque, family(elbow)[0].torque - fit.tare)
    assert fit.nrmse < identify(family(elbow)).nrmse / 2


def test_a_fitted_offset_of_nothing_is_nothing(elbow):
    assert abs(identify(family(elbow, 0.0), corrections=Corrections(tare="fit")).tare) < 0.03


@pytest.mark.slow
def test_auto_takes_the_offset_of_jiles_atherton_where_no_other_model_is_as_good(elbow):
    fit = select(family(elbow, noise=NOISE / 20), corrections=Corrections(tare="fit")).fit
    assert fit.tare == pytest.approx(OFFSET, abs=0.003)
    assert fit.model_name == "jiles-atherton"


@pytest.mark.slow
def test_auto_takes_no_offset_that_a_model_as_good_leaves_open(elbow):
    tried = []
    found = select(family(elbow), corrections=Corrections(tare="fit"), on_candidate=tried.append)
    assert found.fit.tare == 0
    assert found.fit.remarks[0].code == "open"
    assert "do not determine it: 1.3 N·m by jiles-atherton, any by duhem" in str(
        found.fit.remarks[0]
    )
    plain = select(family(elbow))
    assert found.fit.model == plain.fit.model
    assert found.fit.remarks[1:] == plain.fit.remarks
    assert sorted(one.name for one in tried) == sorted(2 * [one.name for one in plain.candidates])
    assert plain.uncertainty().offset_open == (plain.fit.model_name,)


@pytest.mark.slow
def test_the_deviation_of_the_offset_is_that_of_its_estimates(elbow):
    found = []
    for offset in np.linspace(-1, 1, 8):
        fit = identify(family(elbow, offset), corrections=Corrections(tare="fit"))
        term = fit.uncertainty().offset
        assert abs(term.value) < 0.1 * term.deviation + 1e-3 * 7  # the fit has taken it off
        found.append(term.deviation)
        assert abs(fit.tare - offset) < 4 * term.deviation + 1e-3 * 7
    assert np.std(found) < 0.2 * np.mean(found)


def test_a_spring_with_a_rest_angle_leaves_the_offset_open(elbow):
    found = identify(family(elbow), model="bouc-wen").uncertainty()
    assert found.offset is None
    assert found.left_open[0] == "an offset of the torque sensor, if it was not zeroed"
    assert found.offset_open == ("bouc-wen",)
    assert identify(family(elbow, 0.0)).uncertainty().offset_open == ()
    assert "the curves have no times" in found.left_open[1]


def test_the_figure_shows_the_curves_that_were_fitted(elbow):
    angle = sweep(0.52, 1.57, 0.52, samples=60)
    curves = [Curve(angle, elbow.response(angle) + 1.3, "A")]
    fit = identify(curves, corrections=Corrections(tare=1.3))
    figure = loops_figure({"elbow": fit.curves}, {"elbow": {"certified": fit}})
    (ax,) = figure.axes  # nothing was kept out of the fit, so there is no panel for it
    measured, modeled = (line.get_ydata() for line in ax.lines[:2])
    np.testing.assert_allclose(measured, modeled, atol=0.01)
