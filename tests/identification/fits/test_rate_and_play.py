"""Fits of what depends on the rate, and of play, beside and before hysteresis models."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.hysteresis import Backlash, Clipped, JilesAtherton, Viscoelastic
from activesuit.identification import Corrections, Curve, bare, fit_curves
from activesuit.identification.fits.registry import FITS, fit_model, play_of, rate_of
from helpers import family, sweep

NOISE, VISCOUS = 0.05, Corrections(rate="viscous")


def measured(truth, seed=0, noise=NOISE, samples=80):
    """Returns curves of a joint that is moved at speeds which differ by a factor of 20."""
    rng, curves = np.random.default_rng(seed), []
    for turn, speed in ((0.8, 0.3), (1.1, 1.0), (1.4, 0.5), (1.57, 2.0)):
        angle = sweep(0.52, turn, 0.52, samples=samples)
        swelling = speed * (1 + 0.5 * np.sin(np.arange(angle.size - 1) / (samples / 4)))
        time = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)) / swelling)])
        torque = truth.response(angle, time=time) + noise * rng.standard_normal(angle.size)
        curves.append(Curve(angle, torque, f"{turn} rad", time=time))
    return curves


@pytest.fixture
def viscous(elbow):
    return Viscoelastic(model=elbow, damping=0.3)


@pytest.fixture
def relaxing(viscous):
    return replace(viscous, relaxation_stiffness=1.5, relaxation_time=0.4)


@pytest.mark.parametrize("model", [name for name in FITS if name != "prandtl-ishlinskii"])
def test_every_model_finds_the_dashpot_beside_it(viscous, model):
    found = fit_model(model, measured(viscous), np.random.default_rng(0), rate="viscous")
    assert isinstance(found.model, Viscoelastic)
    assert found.model.damping == pytest.approx(0.3, rel=0.05)
    assert found.model.relaxation_stiffness == 0


@pytest.mark.parametrize("model", ["jiles-atherton", "bouc-wen", "hinged-stops"])
def test_a_maxwell_element_is_found_too(relaxing, model):
    found = fit_model(model, measured(relaxing), np.random.default_rng(0), rate="relaxing").model
    assert isinstance(found, Viscoelastic)
    assert found.damping == pytest.approx(0.3, rel=0.1)
    assert found.relaxation_stiffness == pytest.approx(1.5, rel=0.1)
    assert found.relaxation_time == pytest.approx(0.4, rel=0.2)


def test_a_joint_that_does_not_depend_on_the_rate_gets_next_to_nothing(elbow):
    curves = measured(Viscoelastic(model=elbow))
    found = fit_model("jiles-atherton", curves, np.random.default_rng(0), rate="relaxing").model
    rates = np.concatenate([found.rate_torque(curve.angle, curve.time) for curve in curves])
    assert np.abs(rates).max() < NOISE


@pytest.mark.slow
def test_the_remark_leads_to_the_fit_that_describes_the_curves(viscous):
    curves = measured(viscous)
    slow = fit_curves(curves)
    assert ("rate", "viscous") in [remark.option for remark in slow.remarks]
    fit = fit_curves(curves, corrections=VISCOUS)
    assert not any("rate" in str(remark) for remark in fit.remarks)
    assert fit.nrmse < 0.5 * slow.nrmse
    assert rate_of(fit.model) == "viscous"
    drawn = fit.uncertainty(samples=3).samples
    assert [rate_of(model) for model in drawn] == ["viscous"] * 3


@pytest.mark.slow
def test_elements_that_were_not_found_are_reported(elbow, viscous):
    fit = fit_curves(measured(viscous), corrections=Corrections(rate="relaxing"))
    assert rate_of(fit.model) == "viscous"
    said = "no relaxation was found beside the dashpot (corrections=Corrections(rate='viscous'))"
    assert said in map(str, fit.remarks)
    fit = fit_curves(measured(Viscoelastic(model=elbow)), corrections=Corrections(play="fit"))
    assert "no gap was found (corrections=Corrections(play='none'))" in map(str, fit.remarks)


def test_a_model_with_an_angle_range_keeps_it(shoulder):
    truth = Viscoelastic(model=Clipped(model=shoulder, angle_range=(0.3, 1.6)), damping=0.4)
    fit = fit_curves(measured(truth), corrections=VISCOUS)
    assert isinstance(fit.model, Viscoelastic)
    assert isinstance(bare(fit.model.model), JilesAtherton)
    assert fit.model.certificate().certified
    assert fit.uncertainty(samples=2).samples


@pytest.mark.slow
def test_a_dashpot_is_found_around_play(elbow):
    truth = Viscoelastic(model=Backlash(model=elbow, gap=0.05), damping=0.3)
    curves, rng = measured(truth, noise=0.03), np.random.default_rng(0)
    found = fit_model("bouc-wen", curves, rng, rate="viscous", play="fit").model
    assert found.damping == pytest.approx(0.3, rel=0.1)
    assert found.model.gap == pytest.approx(0.05, rel=0.15)


@pytest.mark.parametrize(("lag", "said_lag"), [(0.05, "0.05 s after"), (-0.02, "0.02 s before")])
def test_torque_that_is_measured_at_another_time_is_no_dashpot(elbow, lag, said_lag):
    late = []
    for one in measured(Viscoelastic(model=elbow)):
        known = one.time - lag <= one.time[-1]  # the joint rests before, and goes on after
        torque = np.interp(one.time[known] - lag, one.time, one.torque)
        late.append(Curve(one.angle[known], torque, one.name, time=one.time[known]))
    fit = fit_curves(late, corrections=Corrections(rate="none"))
    assert fit.verdict == "does not describe the curves"
    said = " ".join(map(str, fit.remarks))
    assert f"measured {said_lag} the angle" in said
    assert "--rate viscous" not in said


GAP = 0.05


def unhurried(truth, seed=0):
    return family(truth, (0.8, 1.1, 1.4, 1.57), share=0.01, seed=seed, samples=80)


@pytest.mark.parametrize(
    ("name", "gap", "seed"),
    [
        ("jiles-atherton", 0.02, 0),
        ("jiles-atherton", 0.08, 2),
        ("asymmetric", GAP, 0),
        ("bouc-wen", GAP, 0),
    ],
)
def test_the_gap_is_found_within_a_tenth(elbow, name, gap, seed):
    curves = unhurried(Backlash(model=elbow, gap=gap), seed)
    found = fit_model(name, curves, np.random.default_rng(0), play="fit")
    assert found.model.gap == pytest.approx(gap, rel=0.1)
    assert found.loss < 0.012 or name != "jiles-atherton"


@pytest.mark.slow
def test_a_fit_that_knows_the_play_is_better_and_draws_models_with_play(elbow):
    curves = unhurried(Backlash(model=elbow, gap=GAP))
    tight, loose = fit_curves(curves), fit_curves(curves, corrections=Corrections(play="fit"))
    assert loose.nrmse < 0.7 * tight.nrmse
    assert loose.model.certificate().certified
    known = loose.uncertainty(samples=2)
    low, high = known.intervals[known.names.index("gap")]
    assert low < GAP < high
    assert [play_of(model) for model in known.samples] == ["fit"] * 2
