"""Scores of extras in results of the benchmark: files, merging, and what several settings cost."""

import json
from dataclasses import replace

import numpy as np
import pytest
from activesuit.envs.benchmark import Leaderboard, Setting
from activesuit.envs.benchmark.results import Result, lines, read_results
from activesuit.envs.benchmark.standings import Standings, cost_over, measures_of
from helpers import assert_refused, made_result

MOTIONS = 8
HERE = Setting("ElbowFlexion", "nominal", "emu-like")
THERE = HERE._replace(task="Scoop")


def heat(watts, other=None, **facts):
    """A score of motions that all cost the same; `other` is the cost by another convention."""
    series = {"standard": watts, "other": watts if other is None else other}
    costs = {"heat": {name: [value] * MOTIONS for name, value in series.items()}}
    return {"costs": costs, "facts": facts or {"loaded": {"a": 0.5}}}


def result(policy, setting=HERE, score=None, **changes):
    usual = {**dict.fromkeys(("effort", "tracking"), (0.1,) * MOTIONS), **setting._asdict()}
    usual |= {"success": (True,) * MOTIONS, "extra": {} if score is None else {"toy": score}}
    return made_result(policy=policy, **{**usual, **changes})


SCORES = {"unsuited": heat(90.0), "suited": heat(110.0), "compensation": heat(95.0, 100.0)}
SCORED = [result(name, score=one) for name, one in SCORES.items()]


def over(results, policy="compensation", settings=(HERE,)):
    measures = measures_of(results, "toy", "heat", 0.5)
    return cost_over(Standings(results), policy, settings, measures)


def test_scores_go_through_a_file(tmp_path):
    kept = [*SCORED, result("other", score=heat(None)), result("no", score={"reason": "it tires"})]
    (tmp_path / "a.jsonl").write_text(lines(kept))
    assert read_results([tmp_path / "a.jsonl"]) == kept
    assert "extra" not in json.loads(result("none").to_json())  # as in results of before


def test_a_trial_with_several_scores_counts_once_with_all(tmp_path):
    both = [replace(one, extra={**one.extra, "own": heat(1.0)}) for one in SCORED]
    parts = [[result(name) for name in SCORES], SCORED]
    parts.append([replace(one, extra={"own": heat(1.0)}) for one in SCORED])
    paths = [tmp_path / name for name in "abc"]
    for path, found in zip(paths, parts, strict=True):
        path.write_text(lines(found))
    assert read_results(paths) == read_results(paths[::-1]) == both
    paths[0].write_text(lines([replace(SCORED[0], extra={"toy": SCORES["suited"]})]))
    assert_refused(read_results, [(paths, "have different results of unsuited")])


def test_damaged_scores_are_named():
    rows = [
        ({"costs": {"heat": {"standard": [1.0]}}}, "has not 8 values of toy.heat under 'standard'"),
        ({"costs": {"heat": {"other": [1.0] * 8}}}, "has not 8 values of toy.heat"),
        (heat(-1.0), "extra.toy.costs.heat.other.0"),
        (heat(1.0, loaded={"a" * 201: 0.1}), "extra.toy.facts.loaded"),
        (heat(1.0, loaded="much"), "extra.toy.facts"),
        ({"watts": 1}, "extra.toy.watts"),
    ]
    rows = [(result("none", score=score).to_json(), "line 1", words) for score, words in rows]
    assert_refused(Result.from_json, rows)


def test_settings_have_a_mean_relief_and_its_range():
    found = over(SCORED)
    assert found.mean == pytest.approx(95)
    assert found.relief.value == pytest.approx(15 / 20)
    assert found.between == pytest.approx((10 / 20, 15 / 20))
    assert Standings(SCORED).standing("compensation", [HERE]).relief is None  # efforts are alike


def test_where_relief_has_no_meaning_there_is_none():
    cheap = [SCORED[0], result("suited", score=heat(90.4)), SCORED[2]]
    assert over(cheap)[1:] == (None, None)
    assert over([result("none")], "none") is None
    # Under another convention the suit costs nothing, so that no range over all is known.
    one = [SCORED[0], result("suited", score=heat(110.0, 90.0)), SCORED[2]]
    assert over(one).relief.value == pytest.approx(0.75) and over(one).between is None


def test_a_policy_that_failed_somewhere_has_no_mean_and_no_finite_interval():
    references = [replace(one, task="Scoop") for one in SCORED[:2]]
    size = (np.inf,) * MOTIONS
    failed = result("compensation", THERE, failed="no torque", effort=size)
    found = over([*SCORED, *references, failed], settings=(HERE, THERE))
    assert found.mean == np.inf and found.relief.low == -np.inf


def test_a_score_that_nobody_registered_is_kept_and_said():
    (said,) = Leaderboard(SCORED).scores.values()
    assert said.tables == {} and "no extra with the score 'toy' is here" in said.remarks[0]
