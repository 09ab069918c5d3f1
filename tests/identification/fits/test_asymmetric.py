"""The asymmetric fit: what a polynomial adds, with the certificate kept."""

import numpy as np
import pytest
from activesuit.hysteresis import Asymmetric, Clipped
from activesuit.identification import certified_fit
from activesuit.identification.fits.asymmetric import fit_asymmetric
from activesuit.identification.fits.beginning import common_torque, paper_model
from helpers import family, sweep

START, TURNS, UNSEEN = 0.52, (0.87, 1.22, 1.57), (0.75, 1.05, 1.4)
POLYNOMIAL = (0.0, 3.0, -6.0, 4.0)
NOISE = 0.01  # noise over the peak


def peak(model):
    return np.abs(model.response(sweep(START, TURNS[-1], START))).max()


def prediction(model, known, seed=0, first_torque=0.0):
    """NRMSE on noisy curves with unseen turns."""
    unseen = family(known, UNSEEN, first=first_torque, noise=NOISE * peak(known), seed=seed + 100)
    errors = [model.response(curve.angle, first_torque) - curve.torque for curve in unseen]
    return np.sqrt(np.mean(np.concatenate(errors) ** 2)) / peak(known)


def test_an_asymmetric_truth_is_recovered_where_the_bare_model_is_not(elbow):
    for seed in range(5):
        known = Asymmetric(model=elbow, polynomial=POLYNOMIAL)
        curves = family(known, noise=NOISE * peak(known), seed=seed)
        assert prediction(fit_asymmetric(curves, seed), known, seed) <= 1.3 * NOISE
        bare = paper_model(certified_fit(curves, rng=seed).parameters)
        assert prediction(bare, known, seed) > 2 * NOISE


def test_a_first_torque_is_shared_between_both_parts(elbow):
    known = Asymmetric(model=elbow, polynomial=(1.0, -2.0, 3.0))
    found = fit_asymmetric(family(known, first=0.5), 0, degree=2)
    assert len(found.polynomial) == 3
    for curve in family(known, UNSEEN, first=0.5):
        np.testing.assert_allclose(found.response(curve.angle, 0.5), curve.torque, atol=2e-3)


@pytest.mark.parametrize("name", ["elbow", "shoulder"])
@pytest.mark.parametrize("degree", [1, 3, 5])
def test_what_is_returned_is_certified(name, degree, request):
    known = Asymmetric(model=request.getfixturevalue(name), polynomial=POLYNOMIAL)
    for seed in range(5):
        curves = family(known, noise=NOISE * peak(known), seed=seed)
        found = fit_asymmetric(curves, seed, degree)
        assert len(found.polynomial) == degree + 1
        assert found.certificate().certified
        assert found.certificate().dissipative
        assert found.start_is_certified(found.start(START, common_torque(found, curves)))


def test_a_model_that_is_safe_in_its_range_only_is_constant_outside(shoulder):
    known = Asymmetric(model=shoulder, polynomial=(0.0, 0.0, 1.0))
    found = fit_asymmetric(family(known), 0)
    assert isinstance(found.model, Clipped)
    assert found.model.angle_range == (START, TURNS[-1])
    assert not found.model.model.certificate().certified
    assert prediction(found, known) <= 1.3 * NOISE
