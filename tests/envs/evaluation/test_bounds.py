"""The best known plan: near the bound where that is known, and beaten by no policy."""

import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
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
