"""Sentences about a suit that is validated against itself."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from activesuit.envs.evaluation.sentences import answer

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
