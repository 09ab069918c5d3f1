"""Sentences about failed motions, and about a suit that is validated against itself."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from activesuit.envs.benchmark.leaderboard import benchmark_remarks
from activesuit.envs.benchmark.results import lines, read_results
from activesuit.envs.evaluation.reasons import Oscillation, Reason, most_frequent
from activesuit.envs.evaluation.sentences import answer, why_remarks
from activesuit.envs.tasks.task import EVERYWHERE, TOLERANCES
from activesuit.scripts.main import main
from helpers import made_result

HAND = Reason("hand_error", 0.065, 0.03, "m", 10.5, None)
EFFORT = Reason("effort", 0.229, 0.15, "1", 54.0, "shoulder_flexion")


SWING = Reason("worst_joint", 0.07, 0.03, "rad", 15.5, "shoulder_flexion", Oscillation(2.49, 0.035))


def scored(*why, hot=(), full=(), policy="mine") -> Any:
    success = tuple(not one for one in why)
    joint = "shoulder_flexion"
    given = {"policy": policy, "why": why, "success": success}
    hot = {joint: hot} if hot else {}
    return SimpleNamespace(**given, hot_from=hot, saturated={joint: full or (0.0,) * len(why)})


def test_one_motion():
    (said,) = why_remarks([scored((HAND, EFFORT), hot=(10.52,), full=(0.25,))])
    assert said == (
        "mine failed: hand 65 mm of 30 from 10.5 s; effort 22.9 % of 15 from 54.0 s; shoulder "
        "motor hot from 10.5 s; shoulder motor at its peak in 25 % of the time"
    )
    assert list(why_remarks([scored((), hot=(3.0,))])) == []


def test_the_most_frequent_reason_comes_first_and_successes_do_not_count():
    hot = (float("inf"), 1.0, float("inf"))
    (said,) = why_remarks([scored((EFFORT, HAND), (), (HAND,), hot=hot)])
    assert said == (
        "mine failed in 2 of 3 motions: hand 65 mm of 30 from 10.5 s; "
        "effort 22.9 % of 15 from 54.0 s (1 motion)"
    )


def test_limits_that_the_suited_arm_keeps():
    suited = scored((), (), (EFFORT,), policy="suited")
    first, failed, kept = why_remarks([suited, scored((SWING, HAND), (HAND,), (EFFORT,))])
    assert first.startswith("suited failed") and failed.startswith("mine failed in 3 of 3")
    assert kept.startswith("mine: without assistance the same motions stay within these limits")
    assert kept.endswith(": tracking, the hand's place")
    *_, kept = why_remarks([suited, scored((EFFORT,), (), ())])
    assert kept == "mine: without assistance the same motions stay within this limit: effort"
    unsuited = scored((EFFORT,), (), (), policy="unsuited")
    for other in (unsuited, scored((EFFORT,), (), (EFFORT,)), scored((), (), ())):
        assert "without assistance" not in " ".join(why_remarks([suited, other]))
    heat = Reason("heat", 1.2, 1.0, "1", 1.0, "shoulder_flexion")  # it has no motor
    assert "without assistance" not in " ".join(why_remarks([suited, scored((heat,), (), ())]))


def test_every_limit_has_words():
    for name in (*(one.name for one in EVERYWHERE), *(cost for cost, _ in TOLERANCES.values())):
        reason = Reason(name, 1.25, 1.0, "1", 2.0, "elbow_flexion")
        (said,) = why_remarks([scored((reason,))])
        assert said.startswith("mine failed: ") and "2.0 s" in said
        assert ("arm lost at 2.0 s (elbow)" in said) == (name == "lost")


def test_a_benchmark_names_the_task_and_keeps_the_reasons(tmp_path):
    one = made_result(level="shift", policy="mine", why=most_frequent([(HAND,), ()]))
    why = most_frequent([(HAND, SWING)] * 2)
    other = replace(one, task="Hammer", success=(False, False), why=why)
    (said,) = benchmark_remarks([one, other])
    assert said.startswith("mine at shift failed in 3 of 4 motions: hand 65 mm of 30 from 10.5 s ")
    assert "(3 motions, most in Hammer); shoulder 70 mrad of 30 from 15.5 s, " in said
    assert "oscillates with a period of 2.5 s, amplitude 35 mrad" in said
    file = tmp_path / "results.jsonl"
    file.write_text(lines([one, other]))
    assert read_results([file]) == [one, other]


def test_simulate_says_why(tmp_path, capsys, undrawn):
    env = ["--env", "ActiveSuit/ElbowFlexion-v0", "--max-episode-steps", "100"]
    main(["simulate", *env, "--policy", "none", "--payload", "5", "--out", str(tmp_path)])
    out = capsys.readouterr().out
    assert "none failed: " in out and " % of 17 from " in out


NOISE = 0.001 * np.array([1, -1, 2, -2, 1, -1, 2, -2])
INTERVAL = SimpleNamespace(value=0.05, low=0.03, high=0.09)


def said(own, true, suited=0.16, policy="feedforward", cost=True) -> list[str]:
    """Returns the answer where these are the mean efforts."""
    efforts = {"unsuited": 0.1, "suited": suited, "true model": true, "by suit": own}
    relief = INTERVAL if cost else None
    evaluation: Any = SimpleNamespace(
        scores={name: SimpleNamespace(effort=tuple(e + NOISE)) for name, e in efforts.items()},
        relief=lambda name: relief,
    )
    torque = SimpleNamespace(covered={"elbow_flexion": (0.5, 1.5)}, nrmse=INTERVAL)
    joint = SimpleNamespace(samples=(1,) * 20, left_open=("an offset",), range=(0.0, 2.0))
    found: Any = SimpleNamespace(torque=torque, relief=relief)
    suit: Any = SimpleNamespace(joints={"elbow_flexion": joint})
    return list(answer(found, "suit.json", suit, policy, evaluation))


@pytest.mark.parametrize(
    ("given", "parts"),
    [
        ((0.12, 0.12), ("works less than", "effort 12.0% against 16.0%", "as much as with")),
        ((0.17, 0.12), ("works more than", "effort 17.0% against 16.0%", "more than with")),
        ((0.16, 0.16), ("works as much as", "the limit is the controller", "compensation")),
    ],
)
def test_the_first_sentence_says_whether_the_wearer_works_less_and_what_limits_it(given, parts):
    sentence = said(*given)[0]
    assert [part for part in parts if part not in sentence] == []


def test_no_policy_is_advised_that_was_tried_or_has_nothing_to_give_back():
    assert said(0.17, 0.17, policy="compensation")[0].endswith("not your measurement")
    text = said(0.115, 0.115, suited=0.105, cost=False)
    assert text[0].endswith("little to give back, as the effort without suit is 10.0%")
    assert "no relief that has a meaning" in text[1]
    assert text[-1] == "not contained: an offset; other persons, pressures and tasks"
