"""The fits of Dahl's friction and of the Duhem model: truths come back, with their intervals."""

import numpy as np
import pytest
from activesuit.benchmarks.honesty import truths
from activesuit.errors import InputError
from activesuit.hysteresis import Dahl, Duhem
from activesuit.identification import Certified, Curve, fit_dahl, fit_duhem, identify
from activesuit.identification.fits.registry import FITS, fit_model
from activesuit.identification.prediction import torque_errors
from helpers import sweep

START, TURNS, UNSEEN = 0.52, (0.87, 1.22, 1.57), (0.75, 1.05, 1.4)
SPRING = (-0.6, 2.0, -1.0, 0.8)
TRUTHS = {
    "dahl": Dahl(spring=SPRING, stiffness=12.0, friction=1.5),
    "duhem": Duhem(spring=SPRING, stiffness=12.0, friction_up=2.0, friction_down=0.6),
}
FIT = {"dahl": fit_dahl, "duhem": fit_duhem}
NAMES = pytest.mark.parametrize("name", TRUTHS)


def family(model, turns=TURNS, z=0.0, noise=0.0, seed=0, role="fit"):
    rng = np.random.default_rng(seed)
    curves = []
    for turn in turns:
        angle = sweep(START, turn, START, samples=60)
        torque = model.response(angle, first_torque(model, z))
        torque += noise * rng.standard_normal(angle.size)
        curves.append(Curve(angle, torque, f"{turn}", role))
    return curves


def first_torque(model, z):
    return float(np.polynomial.polynomial.polyval(START, model.spring)) + z


def numbers(model):
    return [one for value in list(model.to_dict().values())[1:] for one in np.atleast_1d(value)]


@NAMES
@pytest.mark.parametrize("z", [0.0, -0.55, 1.4])
def test_a_known_model_comes_back_whatever_its_beginning(name, z):
    for seed in range(3):
        found = FIT[name](family(TRUTHS[name], z=z), seed)
        np.testing.assert_allclose(numbers(found), numbers(TRUTHS[name]), rtol=2e-4, atol=2e-4)


def test_the_fit_of_unlike_ways_finds_equal_ones():
    found = fit_duhem(family(TRUTHS["dahl"]), 0)
    assert found.friction_up == pytest.approx(1.5, rel=1e-3)
    assert found.friction_down == pytest.approx(1.5, rel=1e-3)


@pytest.mark.slow
@NAMES
def test_unseen_curves_are_predicted_under_noise(name):
    known, noise = TRUTHS[name], 0.05
    for seed in range(10):
        fit = identify(family(known, noise=noise, seed=seed), model=name, seed=seed)
        unseen = family(known, UNSEEN)
        errors = [fit.predict(curve) - curve.torque for curve in unseen]
        assert np.sqrt(np.mean(np.concatenate(errors) ** 2)) < 0.5 * noise
        certificate = fit.model.certificate()
        assert certificate.certified
        assert certificate.dissipative


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
        curves = family(known, (0.7, *TURNS), noise=0.03, seed=seed)
        found = identify(curves, model=name).uncertainty()
        low, high = found.intervals.T
        truth = [*numbers(known), first_torque(known, 0.0)]
        assert len(found.names) == known.free_parameters + 1
        inside.append((low <= truth) & (truth <= high))
    assert np.mean(inside) > 0.85


def test_only_certified_models_are_returned(elbow):
    """Also of curves of another kind, and of some that feed energy into the joint."""
    loops = [sweep(START, turn, START, samples=60) for turn in TURNS]
    other = [Curve(angle, elbow.response(angle), f"{angle.max()}") for angle in loops]
    driven = [Curve(c.angle, -c.torque, c.name) for c in other]
    for curves in (other, driven):
        for fit in FIT.values():
            found = fit(curves, 0)
            assert found.certificate().certified
            assert found.certificate().dissipative


def test_a_seed_fixes_the_result_and_other_roles_do_not_count():
    curves = family(TRUTHS["duhem"], noise=0.02)
    wrong = family(TRUTHS["duhem"], UNSEEN, noise=5.0, role="predict")
    assert fit_duhem(curves, 3) == fit_duhem([*curves, *wrong], 3)


@NAMES
def test_it_is_known_by_its_name_and_takes_options(name):
    assert FITS[name] is FIT[name]
    fit = identify(family(TRUTHS[name]), model=name, method=Certified(degree=1))
    assert len(fit.model.spring) == 2


def test_bad_input():
    curves = family(TRUTHS["dahl"])
    apart = Curve(curves[0].angle + 0.3, curves[0].torque, "apart")
    for arguments, message in (
        ({"curves": [*curves, apart]}, r"the curves begin at 0.52 to 0.82 rad"),
        ({"curves": curves, "degree": 0}, "degree is 0: use at least 1"),
        ({"curves": curves, "degree": 6}, "degree is 6: use at most 5"),
        ({"curves": curves, "budget": 8}, "budget is 8: use at least 9"),
        ({"curves": family(TRUTHS["dahl"], role="predict")}, "there is no curve to fit"),
    ):
        for fit in (fit_dahl, fit_duhem):
            with pytest.raises(InputError, match=message):
                fit(**arguments)
