"""Faults that come when wearers have learned that sensors and motors work."""

import numpy as np
import pytest
from activesuit.envs.evaluation import evaluate
from activesuit.envs.evaluation.surprises import surprises
from activesuit.errors import InputError
from helpers import shorten_tasks

ENV = "ActiveSuit/ElbowFlexion-v0"
FAULTS = {
    "none": {},
    "bias": {"torque_bias": 5.0},
    "stopped": {"stopped": ("elbow_flexion",), "since": 1.0},
}


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patch:
        shorten_tasks(patch, 3.0)
        some = surprises(
            ENV,
            ["compensation", "adaptive"],
            FAULTS,
            episodes=8,
            suit="emu-like",
        )
        usual = evaluate(ENV, ["compensation"], episodes=8, suit="emu-like")
        return {(one.policy, one.fault): one for one in some}, usual


def test_without_a_fault_it_is_what_evaluate_says(found):
    same = found[0]["compensation", "none"]
    assert same.score.effort == found[1].scores["compensation"].effort
    assert same.relief == found[1].relief("compensation")
    assert not same.moved.any()
    assert not same.loaded.any()


def test_a_fault_reaches_only_policies_that_use_the_sensor(found):
    assert not found[0]["compensation", "bias"].moved.any()
    wrong = found[0]["adaptive", "bias"]
    assert wrong.moved.min() > 0.01
    assert wrong.relief.value < found[0]["adaptive", "none"].relief.value


def test_a_motor_that_stops_throws_its_load_on_the_wearer(found):
    stopped = found[0]["compensation", "stopped"]
    assert stopped.loaded.min() > 2
    assert stopped.moved.min() > 0.05
    assert np.mean(stopped.score.effort) > np.mean(found[0]["compensation", "none"].score.effort)
    plain = stopped.to_dict()
    assert plain["loaded"]["value"] == pytest.approx(stopped.loaded.mean())


def test_a_fault_out_of_its_range_is_refused():
    with pytest.raises(InputError, match=r"faults\.lost is 2: use a number from 0 to 1"):
        surprises(ENV, ["none"], {"all": {"lost": 2}}, episodes=8)
