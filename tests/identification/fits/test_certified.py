"""Our own fit: derivatives, beginnings, counts, and what a polynomial adds to it."""

import numpy as np
import pytest
from activesuit.hysteresis import Asymmetric, Clipped, JilesAtherton
from activesuit.identification import Curve, CurveObjective, bare, certified_fit
from activesuit.identification.fits.beside_polynomial import fit_asymmetric
from activesuit.identification.fits.certified import CertifiedProblem
from activesuit.identification.fits.search import Search
from helpers import family, prediction_error

NOISE = 0.05


def response(fit, curve):
    return fit.model.response(curve.angle, fit.initial_torque)


def test_derivatives_are_those_of_the_residuals(elbow):
    for initial_torque in [0.0, 0.3, "measured", "identified"]:
        problem = CertifiedProblem(family(elbow, first=0.3, noise=NOISE), initial_torque)
        search = Search(problem, 1000, exact=True)
        for point in problem.starts(search, 0)[:8]:
            expected = []
            for step in 1e-4 * np.eye(point.size):
                rise = search.residual(point + step) - search.residual(point - step)
                expected.append(rise / 2e-4)
            found = search.jacobian(point)
            scale = np.abs(expected).max()
            there = np.array(expected)[:, :-1]
            np.testing.assert_allclose(found.T[:, :-1], there, atol=1e-5 * scale)


@pytest.mark.parametrize("name", ["elbow", "shoulder"])
@pytest.mark.parametrize("first", [1.0, -0.6])
def test_the_torque_at_the_beginning_is_given_or_identified(name, first, request):
    truth = request.getfixturevalue(name)
    curves = family(truth, first=first, noise=NOISE)
    given = certified_fit(curves, rng=0, initial_torque=first)
    found = certified_fit(curves, rng=0, initial_torque="identified")
    peak = CurveObjective(curves).peak
    for fit in (given, found):
        assert fit.loss * peak == pytest.approx(NOISE, rel=0.05)
        assert fit.model.certificate().certified
        state = fit.model.start(curves[0].angle[0], fit.initial_torque)
        assert fit.model.start_is_certified(state)
        errors = np.concatenate([response(fit, curve) - curve.torque for curve in curves])
        assert np.sqrt(np.mean(errors**2)) / peak == pytest.approx(fit.loss, rel=1e-9)
    assert given.initial_torque == first
    assert found.initial_torque == pytest.approx(first, abs=0.03)


def test_curves_that_begin_apart_begin_as_measured(elbow):
    curves = [*family(elbow, (1.57,), first=0.5, noise=NOISE)]
    curves += family(elbow, (0.6,), start=1.4, first=-1.0, noise=NOISE, seed=1)
    fit = certified_fit(curves, rng=0, initial_torque="measured")
    assert fit.initial_torque == "measured"
    for curve in curves:
        predicted = fit.model.response(curve.angle, curve.torque[0])
        assert np.sqrt(np.mean((predicted - curve.torque) ** 2)) < 2 * NOISE


def test_a_heavy_curve_is_fitted_better(elbow):
    # No model fits both of two curves that disagree.
    curves = family(elbow, (1.57, 1.57), noise=NOISE)
    disagreeing = [curves[0], Curve(curves[1].angle, 1.2 * curves[1].torque, "other")]
    heavier = [disagreeing[0], Curve(curves[1].angle, 1.2 * curves[1].torque, "other", weight=50)]

    def error(fitted):
        fit = certified_fit(fitted, rng=0)
        return np.sqrt(np.mean((response(fit, fitted[1]) - fitted[1].torque) ** 2))

    assert error(heavier) < 1.5 * NOISE < error(disagreeing) / 2


def test_history_and_model(elbow, shoulder):
    fit = certified_fit(family(elbow, noise=NOISE), rng=0)
    spent, best = np.array(fit.history).T
    assert (np.diff(spent) >= 0).all()
    assert (np.diff(best) < 0).all()
    assert best[-1] == fit.loss
    assert 32 <= spent[0] <= spent[-1] <= fit.evaluations <= 200
    limited = certified_fit(family(shoulder, noise=NOISE), rng=0)
    assert isinstance(limited.model, Clipped)
    assert limited.model.angle_range == (0.52, 1.57)


def test_two_searches_that_end_in_one_wrong_optimum_are_not_the_end():
    truth = JilesAtherton(Ms=2.12, a=21.2, alpha=1.17, c=8.37, k=334, angle_unit="deg")
    curves = family(truth, noise=NOISE)
    for seed in (1, 2):  # the first two searches end at 6.6 times the noise
        fit = certified_fit(curves, rng=seed)
        assert fit.evaluations <= 300
        assert fit.loss * CurveObjective(curves).peak < 1.1 * NOISE


START, TURNS, UNSEEN = 0.52, (0.87, 1.22, 1.57), (0.75, 1.05, 1.4)
POLYNOMIAL = (0.0, 3.0, -6.0, 4.0)
SHARE = 0.01  # noise over the peak


def prediction(model, known, seed=0):
    return prediction_error(model, known, UNSEEN, share=SHARE, seed=seed + 100)


def test_an_asymmetric_truth_is_recovered_where_the_bare_model_is_not(elbow):
    for seed in range(5):
        known = Asymmetric(model=elbow, polynomial=POLYNOMIAL)
        curves = family(known, share=SHARE, seed=seed)
        assert prediction(fit_asymmetric(curves, seed), known, seed) <= 1.3 * SHARE
        alone = bare(certified_fit(curves, rng=seed).model)
        assert prediction(alone, known, seed) > 2 * SHARE


def test_a_first_torque_is_shared_between_both_parts(elbow):
    known = Asymmetric(model=elbow, polynomial=(1.0, -2.0, 3.0))
    found = fit_asymmetric(family(known, first=0.5), 0, degree=2)
    assert len(found.polynomial) == 3
    for curve in family(known, UNSEEN, first=0.5):
        np.testing.assert_allclose(found.response(curve.angle, 0.5), curve.torque, atol=2e-3)


def test_a_model_that_is_safe_in_its_range_only_is_constant_outside(shoulder):
    known = Asymmetric(model=shoulder, polynomial=(0.0, 0.0, 1.0))
    found = fit_asymmetric(family(known), 0)
    assert isinstance(found.model, Clipped)
    assert found.model.angle_range == (START, TURNS[-1])
    assert not found.model.model.certificate().certified
    assert prediction(found, known) <= 1.3 * SHARE
