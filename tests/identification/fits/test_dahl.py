"""The fits of Dahl's friction and of the Duhem model: truths come back, with their intervals."""

import numpy as np
import pytest
from activesuit.benchmarks.honesty import truths
from activesuit.hysteresis import Dahl, Duhem
from activesuit.identification import Certified, fit_dahl, fit_duhem, identify
from activesuit.identification.fits.registry import FITS, fit_model
from activesuit.identification.prediction import torque_errors
from helpers import assert_refused, family

START, TURNS, UNSEEN = 0.52, (0.87, 1.22, 1.57), (0.75, 1.05, 1.4)
SPRING = (-0.6, 2.0, -1.0, 0.8)
TRUTHS = {
    "dahl": Dahl(spring=SPRING, stiffness=12.0, friction=1.5),
    "duhem": Duhem(spring=SPRING, stiffness=12.0, friction_up=2.0, friction_down=0.6),
}
FIT = {"dahl": fit_dahl, "duhem": fit_duhem}
NAMES = pytest.mark.parametrize("name", TRUTHS)


def first_torque(model, z):
    return float(np.polynomial.polynomial.polyval(START, model.spring)) + z


def beginning(name, turns=TURNS, **options):
    """Curves that begin with no friction."""
    return family(TRUTHS[name], turns, first=first_torque(TRUTHS[name], 0.0), **options)


def numbers(model):
    return [one for value in list(model.to_dict().values())[1:] for one in np.atleast_1d(value)]


@NAMES
@pytest.mark.parametrize("z", [0.0, -0.55, 1.4])
def test_a_known_model_comes_back_whatever_its_beginning(name, z):
    for seed in range(3):
        found = FIT[name](family(TRUTHS[name], first=first_torque(TRUTHS[name], z)), seed)
        np.testing.assert_allclose(numbers(found), numbers(TRUTHS[name]), rtol=2e-4, atol=2e-4)


def test_the_fit_of_unlike_ways_finds_equal_ones():
    found = fit_duhem(beginning("dahl"), 0)
    assert found.friction_up == pytest.approx(1.5, rel=1e-3)
    assert found.friction_down == pytest.approx(1.5, rel=1e-3)


@pytest.mark.slow
@NAMES
def test_unseen_curves_are_predicted_under_noise(name):
    noise = 0.05
    for seed in range(10):
        fit = identify(beginning(name, noise=noise, seed=seed), model=name, seed=seed)
        unseen = beginning(name, UNSEEN)
        errors = [fit.predict(curve) - curve.torque for curve in unseen]
        assert np.sqrt(np.mean(np.concatenate(errors) ** 2)) < 0.5 * noise


@pytest.mark.slow
def test_random_joints_with_unlike_ways_are_described_to_the_noise():
    """Those of `bench honesty`, beside fits of the other models with one state."""
    left = {name: [] for name in ("duhem", "dahl", "bouc-wen", "jiles-atherton")}
    for seed in range(12):
        rng = np.random.default_rng([7, seed])
        truth = truths.duhem(rng)
        curves = truths.measured(truth, (0.0, 1.0), rng)
        noise = np.concatenate([one.torque - truth.torque(one.angle) for one in curves])
        for name, errors in left.items():
            found = fit_model(name, curves, np.random.default_rng(0))
            error = torque_errors(found.model, found.initial_torque, curves)
            errors.append(np.linalg.norm(error) / np.linalg.norm(noise))
    assert max(left.pop("duhem")) < 1.0
    assert min(np.median(errors) for errors in left.values()) > 1.2


@pytest.mark.slow
@NAMES
def test_intervals_contain_the_truth(name):
    """Nominal intervals of 95 %, over 10 families."""
    known, inside = TRUTHS[name], []
    for seed in range(10):
        curves = beginning(name, (0.7, *TURNS), noise=0.03, seed=seed)
        found = identify(curves, model=name).uncertainty()
        low, high = found.intervals.T
        truth = [*numbers(known), first_torque(known, 0.0)]
        assert len(found.names) == known.free_parameters + 1
        inside.append((low <= truth) & (truth <= high))
    assert np.mean(inside) > 0.85


@NAMES
def test_it_is_known_by_its_name_and_takes_options(name):
    assert FITS[name] is FIT[name]
    fit = identify(beginning(name), model=name, method=Certified(degree=1))
    assert len(fit.model.spring) == 2


def test_bad_input():
    rows = [
        ({"degree": 0}, "degree is 0: use at least 1"),
        ({"degree": 6}, "degree is 6: use at most 5"),
        ({"budget": 8}, "budget is 8: use at least 9"),
    ]
    for fit in FIT.values():
        assert_refused(lambda options, fit=fit: fit(beginning("dahl"), **options), rows)
