"""The best known plan: near the bound where that is known, and beaten by no policy."""

import numpy as np
import pytest
from activesuit.envs.evaluation import bounds, evaluate
from activesuit.envs.evaluation.scores import root_mean_square
from helpers import shorten_tasks

POLICIES = ("compensation", "impedance", "observer", "best-known-plan")


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, 6.0)
        return evaluate(
            "ActiveSuit/ArmTracking-v0",
            POLICIES,
            episodes=4,
            suit="mock-suit",
            gravity="microgravity",
        )


def left(found, name):
    """Root mean square of the wearers' torque at the assisted joints [N·m]."""
    return root_mean_square(np.array([trace.human_torque[:, 1:3] for trace in found.traces[name]]))


def test_strong_motors_take_over_all_but_2_percent(found):
    """Without limits of the motors the least torque of the wearer is zero."""
    peak = max(np.abs(trace.assist_torque).max() for trace in found.traces["best-known-plan"])
    assert peak < 25  # N·m, far from the limits
    assert left(found, "best-known-plan") < 0.02 * left(found, "suited")


def test_no_policy_needs_less_effort(found):
    for name in POLICIES:
        mine = np.array(found.scores[name].effort)
        assert (mine >= np.array(found.scores["best-known-plan"].effort)).all()
    assert found.scores["best-known-plan"].success == (True,) * 4


class Aimed:
    """Plans whose effort is their distance from some right ones; stands for the wearers."""

    def __init__(self, right, begin):
        self.right, self.commands, self.tries = right, begin.copy(), 0
        self.effort = self.off(begin)

    def off(self, commands):
        return 1 + np.sqrt(np.mean((commands - self.right) ** 2, axis=(1, 2)))

    def tried(self, commands):
        self.tries += 1
        effort = self.off(commands)
        better = effort < self.effort
        self.commands[better], self.effort = commands[better], np.minimum(effort, self.effort)


@pytest.fixture
def begin():
    time = 0.01 * np.arange(400)
    return np.sin(3 * time + np.arange(3)[:, None])[..., None] * [0.8, 0.4]


def test_a_plan_that_is_late_and_weak_is_searched_for(begin):
    right = np.clip(1.1 * np.concatenate([begin[:, 7:], begin[:, -7:]], axis=1), -1, 1)
    best, passes = Aimed(right, begin), []
    before = best.effort.copy()
    bounds._search(best, passes.append)
    assert (best.effort - 1 < 0.4 * (before - 1)).all()
    assert len(passes) >= 2
    assert np.abs(best.commands).max() <= 1


def test_where_no_shift_helps_two_tries_are_enough(begin):
    best = Aimed(begin, begin)
    bounds._search(best, lambda _: None)
    assert best.tries == 2
    np.testing.assert_array_equal(best.commands, begin)
