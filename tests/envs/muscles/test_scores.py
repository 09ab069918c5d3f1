"""Scores of muscles on short motions: what they must say, and bad input."""

from dataclasses import replace

import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
from activesuit.envs.evaluation.extra_scores import cost_of
from activesuit.envs.muscles import CONVENTIONS, STANDARD, muscle_scores
from activesuit.envs.muscles.scores import SCORE
from activesuit.envs.person import Person, isometric_strength, strength_limits
from helpers import assert_refused

TASK, SHORT = "ActiveSuit/ElbowFlexion-v0", {"max_episode_steps": 60}


def motions(policies=("none",), count=2, **options):
    options = {"gravity": "earth", "adapted": False, **SHORT, **options}
    return evaluate(TASK, list(policies), motions=count, **options).traces


@pytest.fixture(scope="module")
def traces():
    return motions(count=8)


@pytest.fixture(scope="module")
def scores(traces):
    return {name: muscle_scores(one) for name, one in traces.items()}


def test_each_motion_has_a_value_under_each_convention(scores):
    for score in scores.values():
        assert set(score.costs["power"]) == set(score.costs["effort"]) == set(CONVENTIONS)
        assert all(len(values) == 8 for values in score.costs["power"].values())
        assert min(score.costs["power"][STANDARD]) > score.facts["rest"] > 1
        assert score.facts["reserve"] < 0.01
        assert score.facts["saturated"] == score.facts["outside"] == 0
        assert len(score.facts["loaded"]) == 3
        assert set(SCORE.units) == {*score.costs, *score.facts}
        assert set(SCORE.least) == set(score.costs)


def test_suit_and_exoskeleton_cost_the_muscles(scores):
    power = {name: np.mean(score.costs["power"][STANDARD]) for name, score in scores.items()}
    assert power["unsuited"] < power["suited"] < power["none"]
    found = cost_of(scores, "none", "power", SCORE.least["power"])
    assert found.mean == power["none"] and found.relief is not None and found.relief.high < 0
    low, high = found.between
    assert low <= found.relief.value <= high and high - low > 0.01


def test_the_relief_of_the_references_is_known(scores):
    for what, least in SCORE.least.items():
        for name, value in (("unsuited", 1), ("suited", 0)):
            found = cost_of(scores, name, what, least)
            assert found.relief is not None and found.relief.value == pytest.approx(value)
    alike = {**scores, "unsuited": scores["suited"]}
    assert cost_of(alike, "none", "power", 0.5)[1:] == (None, None)


def test_conventions_move_scores_the_way_they_must(scores):
    for score in scores.values():
        power, effort = (
            {name: np.mean(values) for name, values in one.items()}
            for one in (score.costs["power"], score.costs["effort"])
        )
        assert power["relaxed"] < power[STANDARD]
        assert effort["rotation free"] < effort[STANDARD] + 1e-9
        assert effort[STANDARD] < min(effort["cubes"], effort["volume"])
        assert effort["least activation"] > effort[STANDARD]
        assert effort["Bhargava 2004"] == effort[STANDARD]


def test_a_weaker_wearer_needs_more_of_weaker_muscles(traces):
    one = traces["unsuited"][0]
    weaker = replace(one, strength=one.strength / 2, effort=one.effort * 2)
    man, other = (muscle_scores([trace], conventions=["relaxed"]) for trace in (one, weaker))
    twice = 2 * man.costs["effort"]["relaxed"][0]
    assert other.costs["effort"]["relaxed"][0] == pytest.approx(twice, rel=0.02)
    assert other.facts["rest"] == pytest.approx(man.facts["rest"] / 2)


def test_progress_and_threads(traces):
    seen = []
    one, many = (
        muscle_scores(traces["none"], conventions=[], threads=n, on_motion=lambda: seen.append(1))
        for n in (1, 2)
    )
    assert one == many and len(seen) == 16


def test_motions_that_end_at_once_have_no_value(traces):
    one = traces["none"][0]
    cut = ("time", "angle", "rate", "human_torque", "effort", "strength")
    short = replace(one, **{name: getattr(one, name)[:2] for name in cut})
    power = muscle_scores([one, short], conventions=[]).costs["power"][STANDARD]
    assert np.isfinite(power).tolist() == [True, False]
    assert_refused(muscle_scores, [([short], "no motion has 3 samples")])


def test_motions_that_cannot_be_scored(traces):
    one = traces["none"][0]
    angle = np.tile([0.0, 0.5, 2.35, 0.0], (len(one.time), 1))
    average = isometric_strength(Person.percentile("male", 50))
    low, high = strength_limits(average, angle, np.zeros_like(angle))
    bent = replace(one, angle=angle, strength=np.stack([-low, high], axis=1))
    tired = motions(count=1, references=False, fatigue=True)["none"]
    rows = [
        ([bent], None, "100% of the postures are outside"),
        (tired, None, "MyoArm is scaled by one factor: leave fatigue out"),
        ([], ["squared"], "unknown convention 'squared'"),
        ([], None, "there are no motions"),
    ]
    assert_refused(
        lambda found, names: muscle_scores(found, **({"conventions": names} if names else {})), rows
    )
