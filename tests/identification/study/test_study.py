"""A study: trials that follow from their key alone, and verdicts that follow from the numbers."""

import dataclasses
import json

import numpy as np
import pytest
from activesuit.assets import curves_path
from activesuit.errors import InputError
from activesuit.hysteresis import JilesAtherton
from activesuit.identification import Curve, CurveObjective, certified_fit, load_curves
from activesuit.identification.optimizers.sa_pso import sa_pso
from activesuit.identification.study.figures import figures
from activesuit.identification.study.summary import judge, summarize
from activesuit.identification.study.trial import (
    STUDY_METHODS,
    Prediction,
    StudyConfig,
    StudyTrial,
    TrialKey,
    check,
    fingerprint,
    is_multi_order,
    run_trial,
)
from activesuit.published import LI_BOUNDS, LI_CLAIMS

ELBOW = load_curves(curves_path("elbow"))
MOTIONS = load_curves(curves_path("elbow").with_stem("elbow_multi_order"))
SMALL = {"swarm_size": 10, "iterations": 12}


def config(**options) -> StudyConfig:
    given = {"methods": ("sa-pso", "mpso"), "joints": {"elbow": "x"}, "trials": 2, **SMALL}
    return StudyConfig(**(given | options))


def made_up(
    key: TrialKey, fitness: float, spent: int = 60, error: float = 1.0, **motions: Prediction
) -> StudyTrial:
    predictions = {"1.05": Prediction(error, 0.03), "1.40": Prediction(error, 0.04)}
    return StudyTrial(
        key=key,
        parameters=(10.0, 100.0, 0.0, 5.0, 20.0),
        safe_range=None,
        fitness=fitness,
        nrmse=fitness * np.sqrt(CurveObjective(ELBOW.fitted()).torque.size),
        evaluations=130,
        improvements=((1, 10 * fitness), (spent, 1.005 * fitness), (spent + 5, fitness)),
        predictions=predictions | motions,
    )


def judged(sa_pso: dict, mpso: dict, trials: int = 30):
    """Judges trials that differ a little; each argument maps to fitness, spent, error."""
    setup = config(trials=trials)
    given = {"sa-pso": sa_pso, "mpso": mpso}
    made = []
    for key in setup.keys:
        numbers = given[key.method]
        wobble = 1 + 0.01 * np.sin(key.number)
        made.append(made_up(key, **(numbers | {"fitness": numbers["fitness"] * wobble})))
    found = judge(setup, summarize(setup, {"elbow": ELBOW}, made))
    return {judgement.claim.quantity: judgement for judgement in found}


@pytest.mark.parametrize("method", STUDY_METHODS)
def test_every_method_runs_within_its_budget(method):
    setup = config(methods=(method,))
    trial = run_trial(setup, TrialKey("elbow", method, 0), ELBOW)
    objective = CurveObjective(ELBOW.fitted(), loss="paper")
    assert trial.fitness == objective(trial.parameters)[0]
    assert trial.nrmse == objective.nrmse(trial.parameters)[0]
    assert trial.evaluations <= (200 if method == "certified" else setup.evaluations)
    spent, best = np.array(trial.improvements).T
    assert (np.diff(spent) > 0).all()
    assert (np.diff(best) < 0).all()
    assert best[-1] == pytest.approx(trial.fitness, rel=1e-12)
    assert spent[-1] <= trial.evaluations
    assert set(trial.predictions) == {"1.05", "1.40"}
    assert StudyTrial.from_json(trial.to_json()) == trial


def test_the_history_is_the_swarms_own():
    setup = config()
    key = TrialKey("elbow", "sa-pso", 1)
    trial = run_trial(setup, key, ELBOW)
    own = sa_pso(
        CurveObjective(ELBOW.fitted(), loss="paper"),
        LI_BOUNDS,
        swarm_size=10,
        max_iterations=12,
        rng=np.random.default_rng(setup.seed_of(key)),
    )
    np.testing.assert_array_equal(trial.best_after(10 * np.arange(1, 14)), own.history)
    converged = 1 + int(np.argmax(own.history <= 1.01 * own.fun))
    assert trial.convergence_iteration(10) == converged


def test_a_trial_depends_on_its_key_and_the_seed_only():
    alone, among = config(), config(methods=("pso", "mpso"), joints={"a": "y", "elbow": "x"})
    key = TrialKey("elbow", "mpso", 1)
    assert run_trial(alone, key, ELBOW) == run_trial(among, key, ELBOW)
    parameters = {
        run_trial(setup, other, ELBOW).parameters
        for setup, other in (
            (alone, key),
            (alone, key._replace(number=0)),
            (alone, key._replace(joint="shoulder")),
            (config(seed=1), key),
        )
    }
    assert len(parameters) == 4


def test_convergence_and_evaluations_to_target_by_hand():
    trial = made_up(TrialKey("elbow", "mpso", 0), fitness=2.0, spent=60)
    assert trial.convergence_iteration(10) == 6  # the 60th evaluation is the 6th iteration's last
    assert trial.convergence_iteration(59) == 2
    assert trial.evaluations_to(2.005) == 65
    assert trial.evaluations_to(1.99) == np.inf
    best = trial.best_after(np.array([0, 1, 59, 60, 64, 65, 130]))
    np.testing.assert_array_equal(best, [np.inf, 20.0, 20.0, 2.01, 2.01, 2.0, 2.0])


def test_a_pole_on_a_held_out_curve_survives_the_file():
    trial = made_up(TrialKey("elbow", "mpso", 0), fitness=1.0)
    poles = {"A": Prediction(np.inf, np.inf), "B": Prediction(0.1, 0.02)}
    trial = dataclasses.replace(trial, predictions=poles)
    assert StudyTrial.from_json(trial.to_json()) == trial


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"key": 3}', '{"key": ["a", "b", 0]}'])
def test_a_broken_trial_is_refused(text):
    with pytest.raises(InputError, match="not a finished trial"):
        StudyTrial.from_json(text)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("key", ["elbow", "mpso", -1]),
        ("parameters", [1, 2, 3]),
        ("parameters", ["1", "2", "3", "4", "5"]),
        ("fitness", "0.1"),
        ("fitness", -1.0),
        ("nrmse", 10**399),
        ("evaluations", 10.5),
        ("evaluations", True),
        ("improvements", []),
        ("improvements", [[1, None]]),
        ("predictions", {"A": [1.0]}),
        ("safe_range", [0.1]),
        ("extra", 1),
    ],
)
def test_a_spoiled_trial_is_refused(field, value):
    content = json.loads(made_up(TrialKey("elbow", "mpso", 0), fitness=1.0).to_json())
    with pytest.raises(InputError, match=rf"not a finished trial \({field}.*\): delete it"):
        StudyTrial.from_dict({**content, field: value})


def test_numbers_come_back_to_the_last_bit():
    trial = made_up(TrialKey("elbow", "mpso", 0), fitness=1.0)
    numbers = np.exp(np.random.default_rng(0).normal(0, 30, 10_000)).tolist()
    for i in range(0, 10_000, 5):
        some = dataclasses.replace(trial, parameters=tuple(numbers[i : i + 5]))
        assert StudyTrial.from_json(some.to_json()).parameters == some.parameters


def test_a_trial_with_one_error_per_curve_is_refused():
    content = json.loads(made_up(TrialKey("elbow", "mpso", 0), fitness=1.0).to_json())
    content["predictions"] = {"1.05": 0.3}
    with pytest.raises(InputError, match="not a finished trial"):
        StudyTrial.from_json(json.dumps(content))


def test_prediction_errors_by_hand():
    trial = run_trial(config(), TrialKey("elbow", "mpso", 0), [*ELBOW, *MOTIONS])
    Ms, a, alpha, c, k = trial.parameters
    model = JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    peak = ELBOW.fitted().peak
    for curve in (ELBOW[1], MOTIONS[0]):
        assert curve.role == "predict"
        error = model.response(curve.angle) - curve.torque
        found = trial.predictions[curve.name]
        assert found.largest == pytest.approx(np.abs(error).max(), rel=1e-9)
        assert found.nrmse == pytest.approx(np.sqrt(np.mean(error**2)) / peak, rel=1e-9)


def test_motions_that_turn_more_than_once_are_distinguished_from_first_order_curves():
    assert not any(map(is_multi_order, ELBOW))
    assert all(map(is_multi_order, MOTIONS))
    low, high = ELBOW[-1].angle[0], ELBOW[-1].angle.max()
    for curve in MOTIONS:  # motions that need no extrapolation
        assert curve.angle[0] == low
        assert low <= curve.angle.min() < curve.angle.max() <= high


def test_success_and_quartiles():
    setup = config(methods=("mpso",), trials=4)
    noise_fitness = 0.010241 / np.sqrt(1051)  # the elbow's, by its second differences
    levels = np.array([1.0, 1.048, 1.06, 3.0]) * noise_fitness
    made = [made_up(key, fitness) for key, fitness in zip(setup.keys, levels, strict=True)]
    (summary,) = summarize(setup, {"elbow": ELBOW}, made[::-1])
    assert summary.noise == pytest.approx(0.010241, rel=1e-3)
    assert (summary.successes, summary.success_rate) == (2, 0.5)
    assert summary.best == made[0]
    np.testing.assert_allclose(summary.fitness, np.quantile(levels, [0.25, 0.5, 0.75]))
    np.testing.assert_array_equal(summary.evaluations_to_target, [60, 65, np.inf, np.inf])
    assert summary.to_target[0] == 65
    assert np.isinf(summary.to_target[2])


def test_multi_order_beside_first_order_by_hand():
    setup = config(methods=("mpso",), trials=3)
    first = np.sqrt((0.03**2 + 0.04**2) / 2)
    made = []
    for key, ratio in zip(setup.keys, (1.0, 1.2, np.inf), strict=True):
        motions = {
            curve.name: Prediction(i + ratio, ratio * first) for i, curve in enumerate(MOTIONS)
        }
        made.append(made_up(key, fitness=1.0, **motions))
    (summary,) = summarize(setup, {"elbow": [*ELBOW, *MOTIONS]}, made)
    assert set(summary.predictions) == {"1.05", "1.40"}
    multi = summary.multi_order
    assert multi is not None
    assert multi.curves == tuple(curve.name for curve in MOTIONS)
    np.testing.assert_allclose(multi.ratio, [1.2, 1.2, np.inf])
    np.testing.assert_allclose(multi.nrmse, [1.2 * first, 1.2 * first, np.inf])
    np.testing.assert_allclose(multi.first_order, first)
    np.testing.assert_allclose(multi.largest, [3.2, 3.2, np.inf])
    assert multi.as_well == 1


def test_without_first_order_curves_to_predict_there_is_nothing_to_compare():
    setup = config(methods=("mpso",), trials=1)
    family = [*ELBOW.fitted(), *MOTIONS]
    (summary,) = summarize(setup, {"elbow": family}, [run_trial(setup, setup.keys[0], family)])
    assert summary.predictions == {}
    assert summary.multi_order is not None
    assert np.isnan(summary.multi_order.ratio).all()
    assert np.isfinite(summary.multi_order.nrmse).all()


def test_a_fit_at_the_noise_predicts_motions_of_any_order_to_the_noise():
    setup = config(methods=("certified",), trials=5)
    family = [*ELBOW, *MOTIONS]
    (summary,) = summarize(
        setup, {"elbow": family}, [run_trial(setup, key, family) for key in setup.keys]
    )
    assert summary.multi_order is not None
    assert summary.multi_order.nrmse[1] < 1.1 * summary.noise
    assert summary.multi_order.as_well >= 3


def test_a_fit_to_one_motion_of_many_turns_predicts_first_order_curves():
    fit = certified_fit(MOTIONS[:1], rng=0)
    peak = max(np.abs(curve.torque).max() for curve in ELBOW)
    for curve in ELBOW:
        error = fit.model.response(curve.angle) - curve.torque
        assert np.sqrt(np.mean(error**2)) < 1.1 * 0.0102 * peak


def test_verdicts():
    better, worse = {"fitness": 1.0, "spent": 50, "error": 1.0}, {"fitness": 1.6, "spent": 70}
    found = judged(better, worse | {"error": 1.3})
    assert {q: judgement.verdict for q, judgement in found.items()} == {
        "convergence": "reproduced",  # 7 against 5 iterations, printed 20.29 %
        "fitness": "reproduced",  # 60 %, printed 46.5 %
        "prediction": "reproduced",
    }
    assert found["convergence"].advantage == pytest.approx(7 / 5 - 1)
    assert found["fitness"].interval[0] < 0.6 < found["fitness"].interval[1]
    found = judged(worse | {"error": 1.3}, better)
    assert {judgement.verdict for judgement in found.values()} == {"not reproduced"}


def test_a_smaller_advantage_than_printed_does_not_count():
    found = judged({"fitness": 1.0}, {"fitness": 1.2})
    assert found["fitness"].advantage == pytest.approx(0.2, abs=0.01)
    assert found["fitness"].verdict == "not reproduced"


def test_undecidable():
    assert judged({"fitness": 1.0}, {"fitness": 1.6}, trials=9)["fitness"].reason
    pole = judged({"fitness": 1.0, "error": np.inf}, {"fitness": 1.6})
    assert pole["prediction"].verdict == "undecidable"
    assert "pole" in pole["prediction"].reason
    equal = judged({"fitness": 1.0}, {"fitness": 1.0})
    assert equal["prediction"].verdict == "undecidable"  # no difference at all
    alone = config(methods=("mpso",))
    made = [made_up(key, 1.0) for key in alone.keys]
    found = judge(alone, summarize(alone, {"elbow": ELBOW}, made))
    assert {judgement.verdict for judgement in found} == {"undecidable"}


def test_the_printed_percentages_are_of_sa_pso():
    printed = {(claim.joint, claim.quantity): claim.advantage for claim in LI_CLAIMS}
    ratios = {
        ("shoulder", "convergence"): (51, 48),
        ("shoulder", "fitness"): (1.7709, 1.5473),
        ("elbow", "convergence"): (83, 69),
        ("elbow", "fitness"): (1.7243, 1.1770),
    }
    for claim, (mpso, sa_pso_) in ratios.items():
        assert printed[claim] == pytest.approx(mpso / sa_pso_ - 1, abs=1e-3)


def test_figures_of_a_study_with_and_without_held_out_curves():
    setup = config(methods=("sa-pso", "certified"))
    for family in (ELBOW, ELBOW.fitted(), [*ELBOW, *MOTIONS]):
        trials = [run_trial(setup, key, family) for key in setup.keys]
        summaries = summarize(setup, {"elbow": family}, trials)
        drawn = figures(setup, {"elbow": family}, summaries)
        assert ("prediction" in drawn) == (len(family) > 3)
        assert ("multi-order" in drawn) == (len(family) > 5)
        assert {"curves", "convergence", "loops", "ecdf"} <= set(drawn)
        labels = [line.get_label() for line in drawn["loops"].axes[0].lines]
        assert {"sa-pso", "certified"} <= set(labels)
        for name in ("convergence", "ecdf"):
            labels = [line.get_label() for line in drawn[name].axes[0].lines]
            assert {"sa-pso", "certified"} <= set(labels)


def test_fingerprint_sees_every_change():
    curve = ELBOW[0]
    changed = [
        Curve(curve.angle, curve.torque, name="other", role=curve.role),
        Curve(curve.angle, curve.torque, name=curve.name, role="predict"),
        Curve(curve.angle, curve.torque + 1e-9, name=curve.name, role=curve.role),
        Curve(curve.angle, curve.torque, name=curve.name, role=curve.role, weight=2.0),
    ]
    assert len({fingerprint([one]) for one in [curve, *changed]}) == 5
    assert fingerprint(ELBOW) == fingerprint(load_curves(curves_path("elbow")))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"methods": ("sa-psoo",)}, "did you mean 'sa-pso'"),
        ({"methods": ("pso", "pso")}, "'pso' is there twice"),
        ({"methods": ()}, "no method or no joint"),
        ({"joints": {}}, "no method or no joint"),
        ({"trials": 0}, "trials is 0"),
        ({"seed": -1}, "seed is -1"),
        ({"swarm_size": 1}, "swarm_size is 1"),
        ({"iterations": 0}, "iterations is 0"),
    ],
)
def test_bad_configurations(options, message):
    with pytest.raises(InputError, match=message):
        config(**options)


def test_unusable_curves_are_found_before_any_trial():
    with pytest.raises(InputError, match="no curve to fit"):
        check(config(), {"elbow": ELBOW.held_out()})
