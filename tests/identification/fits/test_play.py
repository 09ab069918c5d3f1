"""Fits of hysteresis models behind play in the transmission."""

import numpy as np
import pytest
from activesuit.hysteresis import Backlash
from activesuit.identification import Corrections, fit_curves
from activesuit.identification.fits.registry import fit_model, play_of
from helpers import family

GAP = 0.05


def measured(truth, seed=0, noise=0.01):
    """Returns first-order curves with white noise, a share of the peak."""
    peak = np.abs(truth.response([0.52, 1.57])).max()
    return family(truth, (0.8, 1.1, 1.4, 1.57), noise=noise * peak, seed=seed, samples=80)


@pytest.mark.parametrize(("gap", "seed"), [(0.02, 0), (0.05, 1), (0.08, 2)])
def test_the_gap_is_found_within_a_tenth(elbow, gap, seed):
    curves = measured(Backlash(model=elbow, gap=gap), seed)
    found = fit_model("jiles-atherton", curves, np.random.default_rng(0), play="fit")
    assert found.model.gap == pytest.approx(gap, rel=0.1)
    assert found.loss < 0.012


@pytest.mark.parametrize("name", ["asymmetric", "bouc-wen"])
def test_other_models_find_it_too(elbow, name):
    curves = measured(Backlash(model=elbow, gap=GAP))
    found = fit_model(name, curves, np.random.default_rng(0), play="fit").model
    assert found.gap == pytest.approx(GAP, rel=0.1)


@pytest.mark.slow
def test_a_joint_without_play_gets_none(elbow):
    for seed in range(3):
        fit = fit_curves(measured(elbow, seed), corrections=Corrections(play="fit"))
        assert play_of(fit.model) == "none"


@pytest.mark.slow
def test_a_fit_that_knows_the_play_is_better_and_draws_models_with_play(elbow):
    curves = measured(Backlash(model=elbow, gap=GAP))
    tight, loose = fit_curves(curves), fit_curves(curves, corrections=Corrections(play="fit"))
    assert loose.nrmse < 0.7 * tight.nrmse
    assert loose.model.certificate().certified
    known = loose.uncertainty(samples=2)
    low, high = known.intervals[known.names.index("gap")]
    assert low < GAP < high
    assert [play_of(model) for model in known.samples] == ["fit"] * 2
