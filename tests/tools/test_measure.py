"""Numbers of README and docs: they come from kept results, which are means of the commands' own."""

import json

import pytest
from activesuit.errors import InputError
from activesuit.tools.learners import LEARNERS
from activesuit.tools.measure import (
    EXPERIMENTS,
    FOLDER,
    command_line,
    condensed,
    differences,
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


def test_lists_of_one_number_for_each_motion_become_their_mean():
    found = {"policy": "none", "effort": [0.1] * 10 + [0.3] * 10, "torque": {}, "load": {"a": 1}}
    assert condensed({"scores": [found]}) == {
        "scores": [{"policy": "none", "effort": 0.2, "torque": {}}]
    }
    assert condensed({"success": [True, False] * 4, "tilt": [0.0, 0.123456789], "why": None}) == {
        "success": 0.5,
        "tilt": [0.0, 0.123457],
        "why": None,
    }


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


def test_a_folder_without_a_result_is_refused(tmp_path):
    with pytest.raises(InputError, match="has no result: give the folder of a run"):
        result_of(tmp_path)


def test_numbers_as_text():
    assert interval({"value": -0.001, "low": -1.2, "high": 0.005}) == "0.00 (-1.20 to 0.01)"
    assert interval(None) == "-"
    assert percent(0.0673) == "6.7 %"
