"""What is left out of a fit: whole curves, or the end of one record; and what needs no memory."""

import numpy as np
import pytest
from activesuit.identification import Curve, fit_curves, select
from activesuit.identification.data.parts import questions
from activesuit.identification.judging.judgement import baseline_errors, predictions
from helpers import along, assert_refused, family, spring, sweep

LONG = (0.52, *[1.57, 0.52] * 3, *[1.2, 0.7] * 3, *[1.57, 0.52] * 2)  # two amplitudes


def record(model, *, turns=LONG, drift=0.0, offset=0.0, noise=0.01, seed=0):
    """Returns one continuous record, with noise of 1 % of the peak."""
    angle = sweep(*turns, samples=70)
    cycles = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))]) / (2 * np.ptp(angle))
    torque = model.response(angle) * (1 - drift * cycles) + offset
    errors = np.abs(torque).max() * np.random.default_rng(seed).standard_normal(angle.size)
    return Curve(angle, torque + noise * errors, "record", time=np.linspace(0, 60, angle.size))


def test_each_curve_but_the_farthest_is_left_out(elbow):
    curves = [record(elbow, turns=(0.52, turn, 0.52)) for turn in (0.9, 1.57, 1.2)]
    asked = questions(curves)
    assert [one.curve is curves[i] for one, i in zip(asked, (0, 2), strict=True)] == [True, True]
    assert all(len(one.known) == 2 and one.asked == slice(None) for one in asked)


def test_the_end_of_a_record_is_left_out_block_by_block(elbow):
    one = record(elbow)
    asked = questions([one])
    assert len(asked) == 3
    for question in asked:
        (known,) = question.known
        np.testing.assert_array_equal(known.angle, one.angle[: question.asked.start])
        assert known.time is not None
        part = one.angle[question.asked]
        assert known.angle.min() <= part.min() <= part.max() <= known.angle.max()
        assert known.angle.size >= one.angle.size / 3
    joined = [range(*question.asked.indices(one.angle.size)) for question in asked]
    assert [*joined[0], *joined[1], *joined[2]] == list(range(joined[0].start, one.angle.size))


def test_a_record_without_cycles_leaves_nothing_out(elbow):
    wrong = [(0.52, 1.57, 0.52), (0.52, 0.8, 0.6, 1.57)]
    message = "a record of several cycles, or 2 curves, better 3"
    rows = [(record(elbow, turns=turns), message) for turns in wrong]
    assert_refused(lambda one: questions([one]), rows)


@pytest.mark.slow
def test_a_record_whose_every_cycle_is_larger_than_the_last_is_predicted_beyond(elbow):
    turns = (0.9, *np.ravel([(0.9 + size, 0.9 - size) for size in np.linspace(0.05, 0.5, 10)]))
    one = record(elbow, turns=turns, noise=0.002)
    assert all(question.beyond for question in questions([one]))
    found = select([one])
    assert found.fit.model_name == "jiles-atherton"
    assert found.is_beyond
    assert not any(question.beyond for question in questions([record(elbow)]))
    assert not select([record(elbow)]).is_beyond


@pytest.mark.slow
def test_auto_takes_one_record_with_two_amplitudes(elbow):
    fit = select([record(elbow)]).fit
    assert fit.model_name == "jiles-atherton"
    assert fit.fitted_start
    assert fit.nrmse < 0.011
    assert fit.verdict.startswith("describes the curves")
    assert not [one for one in fit.judgement.causes if one.name == "drift"]
    drifting = select([record(elbow, drift=0.02)]).fit
    (drift,) = [one for one in drifting.judgement.causes if one.name == "drift"]
    assert drift.size == pytest.approx(-0.02, abs=0.006)
    assert drift.remark in drifting.remarks
    above = select([record(elbow, offset=1.3)]).fit
    assert above.initial_torque == pytest.approx(1.3, abs=0.2)
    assert above.nrmse < 0.012


def test_models_without_memory_answer_the_same_questions(elbow):
    curves = family(elbow, noise=0.05)
    fitted, asked = baseline_errors(curves), predictions(questions(curves), curves)
    assert set(fitted) == set(asked)
    assert fitted["a spring with friction"] < fitted["a spring"]
    assert min(fitted.values()) > 0.02


def test_auto_says_that_a_spring_needs_no_memory():
    fit = select(family(spring(5.0), noise=0.1)).fit
    assert fit.verdict == "does not describe the curves"
    assert "memoryless prediction" in [one.kind for one in fit.remarks]


@pytest.mark.parametrize("method", ["certified", "auto"])
def test_noise_alone_is_not_described(method):
    curves = family(spring(0.0), noise=1.0)
    fit = select(curves).fit if method == "auto" else fit_curves(curves)
    assert fit.verdict == "does not describe the curves"
    assert "nothing" in [one.kind for one in fit.remarks]


def test_a_record_that_begins_elsewhere_than_the_model_gets_a_remark(elbow):
    curves = [along(elbow, 0.9, 1.57, 0.52, 1.57, 0.52, first=2.0, noise=0.05, samples=70)]
    (start,) = (one for one in fit_curves(curves).remarks if one.code == "start")
    assert start.values["curves"] == pytest.approx(2, abs=0.2)
    fit = fit_curves(curves, initial_torque="identified")
    assert fit.initial_torque == pytest.approx(2.0, abs=0.1)
    assert "start" not in [one.code for one in fit.remarks]
