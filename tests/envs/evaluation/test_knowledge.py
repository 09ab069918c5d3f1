"""What knowledge of the suit buys."""

import numpy as np
import pytest
from activesuit.assets import load_suit
from activesuit.envs.belief import belief_of
from activesuit.envs.evaluation.knowledge import NONE, TRUE, knowledge
from activesuit.hysteresis.branches import spring
from helpers import shorten_tasks


@pytest.fixture(scope="module")
def found():
    suit = load_suit("emu-like")
    joints = {name: entry for name, entry in suit.joints.items() if name.split("_")[0] != "wrist"}
    angle = np.linspace(0.3, 1.3, 50)
    beliefs = {
        NONE: {},
        "spring": {name: spring(angle, entry.response(angle)) for name, entry in joints.items()},
        "model": {name: belief_of(entry) for name, entry in joints.items()},
    }
    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, 3.0)
        return knowledge(
            "ActiveSuit/ArmTracking-v0",
            beliefs,
            episodes=8,
            suit="emu-like",
            gravity="microgravity",
        )


def test_the_true_model_comes_last_and_is_exact(found):
    assert list(found.relief) == [NONE, "spring", "model", TRUE]
    assert found.torque_error["model"].max() < 1e-3 * found.peak
    np.testing.assert_allclose(found.relief["model"], found.relief[TRUE], atol=1e-3)
    assert found.torque_error[TRUE].tolist() == [0.0] * 8
    errors = [found.torque_error[name].mean() for name in (NONE, "spring", "model")]
    assert errors[0] > errors[1] > errors[2]


def test_gains_are_paired_with_the_best_belief_without_memory(found):
    assert found.without_memory == (NONE, "spring")
    best = found.best_without_memory
    assert found.relief[best].mean() == max(found.relief[name].mean() for name in (NONE, "spring"))
    assert found.gain(NONE) is None
    gain = found.gain("model")
    assert gain.value == pytest.approx(np.mean(found.relief["model"] - found.relief[best]))
    assert gain.low > 0
    assert found.mean_relief(TRUE).low > found.mean_relief(NONE).high
