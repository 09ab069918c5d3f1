"""Two hundred damaged inputs: each is one sentence, and nothing changes on disk."""

import importlib.util

import pytest
from damage import KINDS, attack


@pytest.mark.slow
def test_damaged_inputs_are_one_sentence_each():
    assert len(KINDS) >= 60
    wrong: list[str] = []
    trained = importlib.util.find_spec("stable_baselines3") is not None
    done = attack(200, seed=1, trained=trained, report=wrong.append)
    assert sum(done.values()) == 200
    assert not wrong, "\n".join(wrong)
