"""The fits of Dahl's friction and of the Duhem model: joints they describe, and intervals."""

import numpy as np
import pytest
from activesuit.benchmarks.honesty import truths
from activesuit.hysteresis import Dahl, Duhem
from activesuit.identification import Certified, fit_curves, fit_duhem
from activesuit.identification.fits.objective import torque_errors
from activesuit.identification.fits.registry import fit_model
from helpers import family

START, TURNS = 0.52, (0.87, 1.22, 1.57)
SPRING = (-0.6, 2.0, -1.0, 0.8)
TRUTHS = {
    "dahl": Dahl(spring=SPRING, stiffness=12.0, friction=1.5),
    "duhem": Duhem(spring=SPRING, stiffness=12.0, friction_up=2.0, friction_down=0.6),
}


FIRST = float(np.polynomial.polynomial.polyval(START, SPRING))  # with no friction


def beginning(name, turns=TURNS, **options):
    return family(TRUTHS[name], turns, first=FIRST, **options)


def numbers(model):
    return [one for value in list(model.to_dict().values())[1:] for one in np.atleast_1d(value)]


def test_the_fit_of_unlike_ways_finds_equal_ones():
    found = fit_duhem(beginning("dahl"), 0)
    assert found.friction_up == pytest.approx(1.5, rel=1e-3)
    assert found.friction_down == pytest.approx(1.5, rel=1e-3)


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
@pytest.mark.parametrize("name", TRUTHS)
def test_intervals_contain_the_truth(name):
    """Nominal intervals of 95 %, over 10 families."""
    known, inside = TRUTHS[name], []
    for seed in range(10):
        curves = beginning(name, (0.7, *TURNS), noise=0.03, seed=seed)
        found = fit_curves(curves, model=name).uncertainty()
        low, high = found.intervals.T
        truth = [*numbers(known), FIRST]
        assert len(found.names) == known.free_parameters + 1
        inside.append((low <= truth) & (truth <= high))
    assert np.mean(inside) > 0.85


def test_the_degree_is_an_option():
    fit = fit_curves(beginning("dahl"), model="dahl", method=Certified(degree=1))
    assert len(fit.model.spring) == 2
