"""Numbers of README and docs: they come from kept results, which are means of the commands' own."""

import json

import numpy as np
import pytest
from activesuit.envs.evaluation.relief import relief_interval
from activesuit.errors import InputError
from activesuit.tools.learners import LEARNERS
from activesuit.tools.measure import (
    EXPERIMENTS,
    FOLDER,
    command_line,
    condensed,
    differences,
    intervals,
    kept,
    result_of,
)
from activesuit.tools.results import interval, percent


def test_every_experiment_is_kept_with_its_command():
    for name in EXPERIMENTS:
        content = json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))
        assert content["command"] == command_line(name), name
    # Numbers of version 0.2, which no command gives any more.
    others = {"learning", *(path.stem for path in FOLDER.glob("learning-*.json"))}
    tuned = ("ppo", "recurrent-ppo", "sac")
    others |= {f"hyperparameters-{name}" for name in tuned}  # of `tools.tune_training`
    others |= {f"learner-{name}" for name in LEARNERS}  # of `tools.learners`
    others.add("li-2022-velocity")  # of `reproductions.li_2022_velocity`
    assert {path.stem for path in FOLDER.iterdir()} == set(EXPERIMENTS) | others


def scored(effort, **more):
    series = {"motion": range(10), "assisted_effort": effort, "success": [True] * 10}
    return {
        "policy": "p",
        "effort": effort,
        "torque": {"a": [1.0] * 10},
        "load": {},
        **series,
        **more,
    }


def test_values_by_motion_stay_and_other_lists_become_their_mean():
    found = condensed({"scores": [scored([0.1] * 10, costs={"chatter": [0.5] * 10})]})
    (one,) = found["scores"]
    assert one["effort"] == [0.1] * 10 and one["chatter"] == [0.5] * 10
    assert one["motion"] == [*range(10)] and one["success"] == [True] * 10
    assert one["torque"] == {"a": 1.0} and "load" not in one and "costs" not in one
    assert condensed({"success": [True, False] * 4, "tilt": [0.0, 0.123456789], "why": None}) == {
        "success": 0.5,
        "tilt": [0.0, 0.123457],
        "why": None,
    }


def test_every_interval_follows_from_kept_values():
    rng = np.random.default_rng(0)
    unsuited = rng.uniform(0.1, 0.12, 10)
    efforts = {"unsuited": unsuited, "suited": unsuited + 0.1, "mine": unsuited + 0.04}
    efforts["best-known-plan"] = unsuited + rng.uniform(0.01, 0.02, 10)
    scores = {}
    for name, effort in efforts.items():
        series = [np.array(efforts[one]) for one in ("unsuited", "suited")]
        kept = relief_interval(*series, effort).to_dict()
        scores[name] = scored([*effort.tolist()], relief=kept, assisted_relief=kept)
    result = condensed({"place": {"suit_cost": {"value": 0.1}, "scores": scores}})
    found = {place: (new, old) for place, new, old in intervals(result)}
    for name in efforts:
        new, old = found[f"place.scores.{name}.relief"]
        assert new.to_dict() == pytest.approx(old, abs=1e-4)
    assert found["place.scores.mine.share_of_bound"][0].value == pytest.approx(0.6 / 0.85, abs=0.05)
    assert found["place.suit_cost"][0].value == pytest.approx(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXPERIMENTS)
def test_kept_intervals_are_those_of_the_kept_values(name):
    for place, new, old in intervals(kept(name)):  # none in results of 0.2, which have means alone
        assert (new and new.to_dict()) == pytest.approx(old, abs=1e-3), place


def test_a_run_that_differs_is_found():
    old = {"relief": {"value": 0.7, "low": None}, "effort": 300.0}
    assert list(differences(old, old)) == []
    assert list(differences(old, {"relief": {"value": 0.705, "low": None}, "effort": 302.0})) == []
    new = {"relief": {"value": 0.72, "low": 0.6}, "more": 1.0}
    assert list(differences(old, new)) == [
        "effort is None, and 300.0 is kept",
        "more is 1.0, and None is kept",
        "relief.low is 0.6, and None is kept",
        "relief.value is 0.72, and 0.7 is kept",
    ]


def test_values_by_motion_that_differ_are_found():
    old, new = {"effort": [0.1] * 8}, {"effort": [0.1] * 7 + [0.2]}
    assert list(differences(old, new)) == ["effort.7 is 0.2, and 0.1 is kept"]


def test_a_folder_without_a_result_is_refused(tmp_path):
    with pytest.raises(InputError, match="has no result: give the folder of a run"):
        result_of(tmp_path)


def test_numbers_as_text():
    assert interval({"value": -0.001, "low": -1.2, "high": 0.005}) == "0.00 (-1.20 to 0.01)"
    assert interval(None) == "-"
    assert percent(0.0673) == "6.7 %"
