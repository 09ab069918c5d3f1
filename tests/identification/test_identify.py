import math

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.hysteresis import Held, JilesAtherton
from activesuit.identification import (
    Curve,
    CurveObjective,
    bare,
    certified_fit,
    identify,
    load_curves,
)
from activesuit.identification.certified import noise_floor
from activesuit.identification.identify import PAPER_BOUNDS
from helpers import TABLE_2


def published_nrmse(name, curves):
    """NRMSE of the parameters that the curves were made from: the noise floor of the file."""
    return float(CurveObjective(curves).nrmse(TABLE_2[f"{name}-sa-pso"])[0])


def fitted(name):
    return [curve for curve in load_curves(curves_path(name)) if curve.role == "fit"]


def test_fitness_is_eq_7(small_family, elbow):
    curves = [curve for curve in small_family if curve.role == "fit"]
    rows = np.array([TABLE_2["elbow-sa-pso"], TABLE_2["elbow-mpso"]])
    objective = CurveObjective(curves)
    measured = np.concatenate([curve.torque for curve in curves])
    calculated = np.concatenate([elbow.response(curve.angle) for curve in curves])
    N, peak = measured.size, np.abs(measured).max()
    expected = math.sqrt(sum(((calculated - measured) / peak) ** 2)) / N
    assert objective(rows)[0] == pytest.approx(expected, rel=1e-9)
    assert objective.nrmse(rows)[0] == pytest.approx(expected * math.sqrt(N), rel=1e-9)
    assert objective.evaluations == 4


def test_parameters_with_a_pole_score_infinity(small_family):
    objective = CurveObjective(small_family)
    scores = objective([[22.0, 30.0, 9.0, 6.0, 20.0], TABLE_2["elbow-sa-pso"]])
    assert scores[0] == math.inf
    assert scores[1] < 0.01


@pytest.mark.parametrize("joint", ["shoulder", "elbow"])
def test_certified_fit_reaches_the_noise_floor(joint):
    curves = load_curves(curves_path(joint))
    measured = fitted(joint)
    floor = published_nrmse(joint, measured)
    fits = [certified_fit(measured, rng=seed) for seed in range(40)]
    assert sum(fit.nrmse <= 1.05 * floor for fit in fits) >= 38
    assert max(fit.evaluations for fit in fits) <= 200
    fit = identify(curves)
    assert fit.model.certificate().certified
    assert fit.model.certificate().dissipative
    assert max(fit.prediction_errors.values()) < 0.35  # the noise itself reaches 0.3


def test_a_model_that_is_safe_in_its_range_only_is_held_outside():
    curves = fitted("shoulder")
    model = identify(curves).model
    assert isinstance(model, Held)
    assert model.angle_range == (0.35, 1.22)
    assert not bare(model).certificate().certified
    rng = np.random.default_rng(0)
    for _ in range(50):
        torque = model.response(np.concatenate([[0.35], rng.normal(0.8, 1, 50)]))
        assert np.abs(torque).max() <= model.certificate().torque_bound
    assert isinstance(identify(fitted("elbow")).model, JilesAtherton)


def test_certified_fit_recovers_a_certified_truth_without_noise(table_2):
    truth = table_2["elbow-mpso"]
    curves = [
        Curve(angle, truth.response(angle), str(i))
        for i, angle in enumerate(
            np.concatenate([np.linspace(0.52, top, 80), np.linspace(top, 0.52, 80)[1:]])
            for top in (0.87, 1.22, 1.57)
        )
    ]
    fit = certified_fit(curves, rng=0, budget=1000)
    assert fit.nrmse < 2e-4
    assert fit.history[-1] == fit.nrmse


def test_budget_is_kept(small_family):
    for budget in (33, 60):
        assert certified_fit(small_family, rng=0, budget=budget).evaluations <= budget


def test_noise_estimate():
    for name in ("elbow", "shoulder"):
        curves = load_curves(curves_path(name))
        peak = max(np.abs(curve.torque).max() for curve in curves)
        assert noise_floor(curves) / peak == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("method", ["sa-pso", "mpso", "pso"])
def test_swarm_identification(small_family, method):
    options = {"swarm_size": 20, "max_iterations": 15}
    seen = []
    fit = identify(small_family, method=method, trials=4, seed=7, on_trial=seen.append, **options)
    assert sorted(trial.index for trial in seen) == [0, 1, 2, 3]
    assert fit.nrmse == min(trial.nrmse for trial in fit.trials)
    assert fit.evaluations == 4 * 20 * 16
    low, high = np.array(PAPER_BOUNDS).T
    for trial in fit.trials:
        assert (np.array(trial.parameters) >= low).all()
        assert (np.array(trial.parameters) <= high).all()
        assert len(trial.history) == 16
    alone = identify(small_family, method=method, trials=4, seed=7, workers=1, **options)
    assert alone.trials == fit.trials
    other = identify(small_family, method=method, trials=4, seed=8, **options)
    assert other.trials != fit.trials


def test_interrupt_keeps_finished_trials(small_family):
    def interrupt(trial):
        raise KeyboardInterrupt

    fit = identify(
        small_family,
        method="mpso",
        trials=6,
        workers=1,
        on_trial=interrupt,
        swarm_size=5,
        max_iterations=3,
    )
    assert fit.interrupted
    assert 1 <= len(fit.trials) < 6


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "sapso"}, "unknown method 'sapso'.*did you mean 'sa-pso'"),
        ({"model": "preisach"}, "unknown model 'preisach'"),
        ({"trials": 0}, "trials is 0"),
        ({"seed": -1}, "seed is -1: use at least 0"),
        ({"workers": 0}, "workers is 0"),
        ({"method": "pso", "swarm_size": 1}, "swarm_size is 1"),
        ({"budget": 10}, "budget is 10: use at least 33"),
    ],
)
def test_bad_options(small_family, options, message):
    with pytest.raises(InputError, match=message):
        identify(small_family, **options)


def test_nothing_to_fit(small_family):
    only = [curve for curve in small_family if curve.role == "predict"]
    with pytest.raises(InputError, match="no curve to fit"):
        identify(only)
    flat = [Curve(np.linspace(0, 1, 20), np.zeros(20), "flat")]
    with pytest.raises(InputError, match="every torque is zero"):
        identify(flat)
