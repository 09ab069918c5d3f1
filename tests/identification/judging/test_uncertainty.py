"""Uncertainty of parameters: textbook formulas and Monte Carlo; `honesty` has the coverage."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.hysteresis import Clipped, JilesAtherton
from activesuit.hysteresis.jiles_atherton import PARAMETERS
from activesuit.identification import Curve, bare, certified_fit, fit_curves, uncertainty
from activesuit.identification.fits.certified import refined
from activesuit.identification.fits.tangent import coordinates_of, tangent
from activesuit.identification.judging.noise import GRID, Noise
from activesuit.identification.judging.uncertainty import estimator_covariance
from helpers import assert_refused, family, sweep


def parameters(model):
    return np.array([getattr(bare(model), name) for name in PARAMETERS])


def jacobian(model, curves):
    """Central differences of the torque with respect to Ms, a, alpha, c, k."""
    columns = []
    for name in PARAMETERS:
        step = 1e-3 * abs(getattr(model, name))
        high, low = (replace(model, **{name: getattr(model, name) + s * step}) for s in (1, -1))
        rise = [high.response(one.angle) - low.response(one.angle) for one in curves]
        columns.append(np.concatenate(rise) / (2 * step))
    return np.column_stack(columns)


WHITE = Noise(weight=np.eye(len(GRID))[0], variance=np.full(len(GRID), 0.0025), freedom=300)


@pytest.mark.parametrize("angle_unit", ["deg", "rad"])
def test_derivatives_are_those_of_the_numbers(elbow, angle_unit):
    model = elbow.in_unit(angle_unit)
    curves = family(model, noise=0.05)
    found = coordinates_of(model, 0.0, fitted_start=False)
    assert found.names == PARAMETERS
    np.testing.assert_allclose(found.values, parameters(model))
    slopes = tangent(found, curves) / found.slopes()
    np.testing.assert_allclose(slopes, jacobian(model, curves), rtol=1e-3, atol=1e-6)


def test_covariance_under_white_noise_is_the_textbook_formula(elbow):
    curves = family(elbow, noise=0.05)
    J = jacobian(elbow, curves)
    J = J / np.linalg.norm(J, axis=0)
    sizes = [one.torque.size for one in curves]
    found = estimator_covariance(J, WHITE, sizes, np.ones(len(J)))
    np.testing.assert_allclose(found, 0.0025 * np.linalg.inv(J.T @ J), rtol=1e-6)


@pytest.mark.parametrize(
    ("even", "share", "trials", "tolerance"), [(0.01, 0.0, 150, 0.25), (0.0, 0.02, 100, 0.3)]
)
def test_standard_errors_are_those_of_many_noisy_fits(elbow, even, share, trials, tolerance):
    """Were noise in proportion taken as even, those of large torques would be 30 % too small.

    The deviation of a standard deviation is 1 / sqrt(2 n) of it, 6 and 7 % here.
    """

    def noisy(seed):
        rng, curves = np.random.default_rng([seed, 5]), []
        for one in family(elbow):
            deviation = even + share * np.abs(one.torque)
            noise = deviation * rng.standard_normal(one.torque.size)
            curves.append(replace(one, torque=one.torque + noise))
        return curves

    fits = [refined(noisy(seed), parameters(elbow)) for seed in range(trials)]
    spread = np.std([parameters(fit.model) for fit in fits], axis=0, ddof=1)
    found = [uncertainty(elbow, noisy(seed)) for seed in range(10)]
    stated = np.mean([one.standard_errors for one in found], axis=0)
    np.testing.assert_allclose(spread, stated, rtol=tolerance)
    assert np.mean([one.noise.share for one in found]) == pytest.approx(share, rel=0.1)


@pytest.mark.parametrize("name", ["asymmetric", "bouc-wen", "prandtl-ishlinskii", "preisach"])
def test_every_model_has_intervals_and_samples(elbow, name):
    fit = fit_curves(family(elbow, noise=0.05), model=name)
    found = fit.uncertainty(samples=2)
    assert found.names[-1] == "initial_torque"
    assert (found.intervals[:, 0] <= found.values).all()
    assert (found.values <= found.intervals[:, 1]).all()
    assert len(set(map(str, found.samples))) == 2
    assert all(one.certificate().dissipative for one in found.samples)
    low, high = found.band(fit.curves[0])
    assert ((high - low)[5:] > 0).all()
    assert np.mean(high - low) < 0.5


def test_a_binding_certificate_makes_intervals_one_sided(shoulder):
    fit = fit_curves(family(replace(shoulder, alpha=1.05 * shoulder.alpha), noise=0.05))
    assert "certificate" in [one.code for one in fit.remarks]
    found = fit.uncertainty()
    down, up = np.abs(np.log(found.intervals[1] / found.values[1]))  # of a
    assert max(up, down) > 1.2 * min(up, down)


def test_published_sets_are_poorly_known(table_2):
    condition = [uncertainty(one, family(one, noise=0.05)).condition for one in table_2.values()]
    assert min(condition) > 100
    assert 1e4 < max(condition) < 1e6


def test_parameters_without_a_limit_are_named_by_the_end_that_is_missing(table_2):
    # Far below saturation Man is a straight line, and only its slope Ms / (3a) acts.
    model = table_2["elbow-mpso"]
    found = uncertainty(model, family(model, noise=0.05))
    assert (found.intervals[:2, 1] > 50 * found.values[:2]).all()
    assert (found.intervals[:2, 0] > 0).all()
    assert np.isfinite(found.intervals[2:]).all()
    assert set(found.open_ends) <= {"upper limit"}
    ends = [[0, np.inf], [0, np.inf], [0, 1], [1, 2], [1, 2]]
    coordinates = replace(found._coordinates, least=np.zeros(5))
    open_ends = replace(found, intervals=np.array(ends), _coordinates=coordinates).open_ends
    assert open_ends == {"limit": ["Ms", "a"], "lower limit": ["alpha"]}


@pytest.mark.parametrize("name", ["elbow", "shoulder"])
def test_samples_are_certified_seeded_and_predict(name, request):
    truth = request.getfixturevalue(name)
    curves = family(truth, noise=0.05)
    model = certified_fit(curves, rng=0).model
    found = uncertainty(model, curves, samples=20, seed=3)
    assert found.samples == uncertainty(model, curves, samples=20, seed=3).samples
    assert found.samples[0] != uncertainty(model, curves, samples=1, seed=4).samples[0]
    assert len(set(found.samples)) >= 15  # at the limit of a certificate some stay where they are
    certificates = [one.certificate() for one in found.samples]
    assert all(one.certified and one.dissipative for one in certificates)
    angle = sweep(0.52, 1.4, 0.52)
    predicted = np.array([one.response(angle) for one in found.samples])
    errors = np.sqrt(np.mean((predicted - truth.response(angle)) ** 2, axis=1))
    assert errors.max() < 0.05  # the noise
    spread = np.std([parameters(one) for one in found.samples], axis=0, ddof=1)
    assert (np.abs(np.log(spread / found.standard_errors)) < np.log(3)).all()


def test_the_torque_at_the_beginning_is_one_parameter_more(elbow):
    curves = family(elbow, noise=0.05, first=0.8)
    fit = certified_fit(curves, rng=0, initial_torque="identified")
    begun = {"initial_torque": fit.initial_torque, "fitted_start": True}
    found = uncertainty(fit.model, curves, **begun, samples=2)
    assert found.names == (*PARAMETERS, "initial_torque")
    assert found.values[5] == pytest.approx(fit.initial_torque, abs=1e-3)
    low, high = found.intervals[5]
    assert low < 0.8 < high
    given = uncertainty(fit.model, curves, initial_torque=0.8)
    assert (given.standard_errors <= 1.01 * found.standard_errors[:5]).all()


def test_weights_count_like_repetitions(elbow):
    once = family(elbow, noise=0.05)
    heavy = [replace(once[0], weight=3.0), *once[1:]]
    thrice = [*(replace(once[0], name=f"{i}") for i in range(3)), *once[1:]]
    weighted, repeated = (uncertainty(elbow, curves) for curves in (heavy, thrice))
    few, many = (sum(one.torque.size for one in curves) for curves in (heavy, thrice))
    # Repetitions pretend to be more samples, and the noise to be better known.
    expected = repeated.standard_errors * np.sqrt((many - 5) / (few - 5))
    np.testing.assert_allclose(weighted.standard_errors, expected, rtol=0.1)


def test_a_model_with_an_angle_range_counts_in_its_range(elbow):
    limited = Clipped(model=elbow, angle_range=(0.52, 1.0))
    curves = family(limited, noise=0.05)
    assert uncertainty(limited, curves).noise.deviation == pytest.approx(0.05, rel=0.1)
    assert uncertainty(elbow, curves).noise.deviation > 0.1


def test_bad_input(elbow):
    curves = family(elbow, noise=0.05)
    short = Curve(curves[0].angle[:5], curves[0].torque[:5], "short")
    pole = JilesAtherton(Ms=22.0, a=30.0, alpha=9.0, c=6.0, k=20.0, angle_unit="deg")
    rows = [
        (elbow, curves, -1, "samples is -1"),
        (elbow, [], 0, "0 samples in all"),
        (elbow, [short], 0, "more than the 5 parameters"),
        (pole, curves, 0, "meets its pole"),
    ]
    assert_refused(lambda model, given, n: uncertainty(model, given, samples=n), rows)
