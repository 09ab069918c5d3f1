import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.hysteresis import BoucWen
from activesuit.hysteresis.jiles_atherton.model import PARAMETERS
from activesuit.identification import (
    Certified,
    Corrections,
    Curve,
    CurveObjective,
    Search,
    bare,
    certified_fit,
    fit_curves,
    load_curves,
    register_fit,
    register_optimizer,
    select,
)
from activesuit.identification.fits.registry import FITS
from activesuit.identification.methods import method_names
from activesuit.identification.swarms.variants import OPTIMIZERS
from activesuit.published import LI_BOUNDS
from helpers import TABLE_2, assert_refused, family, interrupt, is_safe
from scipy.optimize import OptimizeResult


@pytest.mark.parametrize("joint", ["shoulder", "elbow"])
def test_certified_fit_reaches_the_noise_floor(joint):
    curves = load_curves(curves_path(joint))
    measured = curves.fitted()
    floor = CurveObjective(measured).nrmse(TABLE_2[f"{joint}-sa-pso"])[0]  # made from these
    fits = [certified_fit(measured, rng=seed) for seed in range(40)]
    assert sum(fit.loss <= 1.05 * floor for fit in fits) >= 38
    assert max(fit.evaluations for fit in fits) <= 200
    fit = fit_curves(curves)
    assert is_safe(fit.model)
    assert max(fit.prediction_errors.values()) < 0.35  # the noise itself reaches 0.3


def test_certified_fit_recovers_a_certified_truth_without_noise(table_2):
    fit = certified_fit(family(table_2["elbow-mpso"], samples=80), rng=0, budget=1000)
    assert fit.loss < 2e-4


@pytest.mark.parametrize("method", ["sa-pso", "mpso", "pso"])
def test_swarm_identification(small_family, method):
    search = Search(method, trials=4, swarm_size=20, max_iterations=15)
    seen = []
    fit = fit_curves(small_family, method=search, seed=7, on_trial=seen.append)
    assert sorted(trial.index for trial in seen) == [0, 1, 2, 3]
    assert fit.nrmse == min(trial.nrmse for trial in fit.trials)
    assert fit.evaluations == 4 * 20 * 16
    low, high = np.array(LI_BOUNDS).T
    for trial in fit.trials:
        parameters = [getattr(trial.model, name) for name in PARAMETERS]
        assert ((low <= parameters) & (parameters <= high)).all()
        assert len(trial.history) == 16
        assert trial.history[-1] == trial.loss
    assert fit_curves(small_family, method=search, seed=7, workers=1).trials == fit.trials
    assert fit_curves(small_family, method=search, seed=8).trials != fit.trials


def test_interrupt_keeps_finished_trials(small_family):
    search = Search("mpso", trials=6, swarm_size=5, max_iterations=3)
    fit = fit_curves(small_family, method=search, workers=1, on_trial=interrupt)
    assert fit.interrupted
    assert 1 <= len(fit.trials) < 6


def test_bad_options(small_family):
    other, twice = {"model": "bouc-wen", "method": "pso"}, {"model": "preisach"}
    rows = [
        ({"method": "sapso"}, "unknown method 'sapso'.*did you mean 'sa-pso'"),
        ({"model": "preisac"}, "unknown model 'preisac'.*did you mean 'preisach'"),
        (other, "method is 'pso': model 'bouc-wen' has the method 'certified' only"),
        ({"method": Search("pso", objective="ssee")}, "unknown loss 'ssee'"),
        ({"initial_torque": "measurd"}, "unknown initial_torque 'measurd'"),
        ({"initial_torque": float("nan")}, "initial_torque is nan"),
        (twice | {"initial_torque": 0.5}, "initial_torque is 0.5.*identify it"),
        (twice | {"method": Certified(trials=3)}, "trials is 3: the fit of 'preisach'"),
        ({"method": Certified(swarm_size=9)}, "unknown certified option 'swarm_size': use one of"),
        ({"method": Search("pso", swarmsize=9)}, "did you mean 'swarm_size'"),
        ({"seed": -1}, "seed is -1: use at least 0"),
        ({"workers": 0}, "workers is 0"),
        ({"method": Search("pso", swarm_size=1)}, "swarm_size is 1"),
        ({"method": Certified(budget=10)}, "budget is 10: use at least 33"),
    ]
    assert_refused(lambda options: fit_curves(small_family, **options), rows)
    rows = [
        (Certified, {"trials": 0}, "trials is 0: use at least 1"),
        (partial(Search, "pso"), {"trials": 0}, "trials is 0: use at least 1"),
        (partial(Search, "sapso"), {}, "unknown method 'sapso'.*did you mean 'sa-pso'"),
        (partial(bare, TRUTH), {}, "model is 'bouc-wen': give a Jiles-Atherton model"),
    ]
    assert_refused(lambda call, options: call(**options), rows)


def test_bad_corrections(small_family):
    negated = [replace(one, torque=-one.torque) for one in small_family]
    rows = [
        ({"play": "fit"}, {"method": "pso"}, "play is 'fit', which the method 'pso' does not fit"),
        ({"play": "fitted"}, {}, "unknown play 'fitted': use one of fit, none"),
        ({"rate": "viscous"}, {"method": "pso"}, "rate is 'viscous', which the method 'pso' does"),
        ({"rate": "viscous"}, {}, "no times, and the model depends on the rate: add the"),
        ({"rate": "visc"}, {}, r"'visc'.*did you mean 'viscous'"),
        ({"tare": "fit"}, {"model": "bouc-wen"}, "fits these curves with any offset"),
        ({"tare": "fit"}, {"curves": negated}, "change its sign"),
        ({"tare": "zeros"}, {}, "tare is 'zeros': give a number"),
        ({"tare": np.array([1.0, 2.0])}, {}, "tare is array"),
        ({"tare": float("nan")}, {}, "tare is nan"),
        ({"softening": "fitted"}, {}, "unknown softening 'fitted': use one of fit, none"),
        ({"softening": "fit", "tare": "fit"}, {}, "tare and softening are both 'fit': fit"),
        ({"softening": "fit"}, {"curves": small_family[:1]}, "cycles of their range: .* least 2"),
        ({"softening": "fit", "average_cycles": True}, {}, "hides what softening looks for"),
    ]

    def tried(corrections, options):
        fit_curves(**{"curves": small_family} | options, corrections=Corrections(**corrections))

    assert_refused(tried, rows)


@pytest.mark.parametrize(
    "options", [{}, pytest.param({"method": Search("mpso", trials=2)}, marks=pytest.mark.slow)]
)
def test_the_beginning_of_the_curves(elbow, options):
    loaded = family(elbow, first=0.4, noise=0.03)
    starts = (0.0, 0.4, "identified", "measured")
    fits = {given: fit_curves(loaded, initial_torque=given, **options) for given in starts}
    assert fits[0.4].initial_torque == 0.4
    assert fits["identified"].initial_torque == pytest.approx(0.4, abs=0.1)
    assert fits["measured"].initial_torque == "measured"
    for given in (0.4, "identified", "measured"):
        assert fits[given].nrmse < 0.5 * fits[0.0].nrmse
    for curve in loaded:
        assert fits["measured"].predict(curve)[0] == curve.torque[0]


def test_the_objective_decides_which_trial_is_best(small_family):
    rng = np.random.default_rng(5)
    spoiled = []
    for curve in small_family:
        outliers = 3.0 * (rng.random(curve.torque.size) < 0.05)
        spoiled.append(Curve(curve.angle, curve.torque + outliers, curve.name, curve.role))
    few = {"trials": 6, "swarm_size": 20, "max_iterations": 30}
    fits = {}
    for loss in ("paper", "robust"):
        fits[loss] = fit_curves(spoiled, method=Search("sa-pso", objective=loss, **few))
    for fit in fits.values():
        best = min(fit.trials, key=lambda trial: trial.loss)
        assert fit.model == best.model
        assert fit.fitness == pytest.approx(fit.nrmse / math.sqrt(3 * 119))
    assert fits["paper"].fitness == pytest.approx(min(t.loss for t in fits["paper"].trials))
    by_curve = fit_curves(spoiled, method=Search("sa-pso", normalize="curve", **few))
    assert by_curve.trials != fits["paper"].trials


def test_weights_count_or_are_refused(small_family):
    weighted = [replace(c, weight=9.0 if c.name == "1.57" else 1.0) for c in small_family]
    assert fit_curves(weighted).model != fit_curves(small_family).model
    behind = partial(fit_curves, corrections=Corrections(play="fit"))
    for fit in (partial(fit_curves, model="bouc-wen"), behind, select):
        with pytest.raises(InputError, match="weights from 1 to 9: only fits of the model"):
            fit(weighted)


TRUTH = BoucWen(elastic=2.0, hysteretic=4.0, beta=4.0, gamma=1.0, n=1.0, rest_angle=0.52)


def test_a_fit_from_outside_the_package(small_family, monkeypatch):
    monkeypatch.setitem(FITS, "soft", None)  # monkeypatch removes the name after the test
    del FITS["soft"]

    def soft(curves, scale: float = 1.0):
        return replace(TRUTH, elastic=scale)

    register_fit("soft", soft)
    register_fit("soft", soft)
    fit = fit_curves(small_family, method=Certified(scale=2.0), model="soft")
    assert (fit.model_name, fit.model.elastic) == ("soft", 2.0)
    assert fit.evaluations is None
    rows = [
        ({"size": 2}, "unknown certified option 'size': use one of scale"),
        ({"trials": 2}, "trials is 2: the fit of 'soft' is made once"),
    ]
    assert_refused(lambda o: fit_curves(small_family, method=Certified(**o), model="soft"), rows)
    rows = [("bouc-wen", soft, "has a fit already"), ("hard", 3, "fit of 'hard' is 3: give a f")]
    assert_refused(register_fit, rows)


def test_an_optimizer_from_outside_the_package(small_family, monkeypatch):
    monkeypatch.setitem(OPTIMIZERS, "drawn", None)  # monkeypatch removes the name after the test
    del OPTIMIZERS["drawn"]

    def drawn(objective, bounds, rng, count: int = 200):
        points = rng.uniform(*np.transpose(bounds), (count, len(bounds)))
        values = objective(points)
        best = np.minimum.accumulate(values)
        return OptimizeResult(x=points[values.argmin()], fun=values.min(), history=best)

    register_optimizer("drawn", drawn)
    register_optimizer("drawn", drawn)
    assert "drawn" in method_names()
    one, two = fit_curves(small_family, method=Search("drawn", trials=2, count=300)).trials
    assert (one.evaluations, len(one.history)) == (300, 300)
    assert one.loss != two.loss
    wrong = [(Search("drawn", size=2), "unknown drawn option 'size': use one of count")]
    assert_refused(lambda method: fit_curves(small_family, method=method), wrong)
    rows = [(name, drawn, f"there is another method '{name}'") for name in ("mpso", "certified")]
    assert_refused(register_optimizer, [*rows, ("hard", 3, "optimizer 'hard' is 3: give a func")])
