"""Damaged inputs, one of each kind: each is one sentence, and nothing changes on disk."""

import pytest
from damage import attack


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_damaged_inputs_are_one_sentence_each():
    wrong: list[str] = []
    done = attack(None, seed=1, report=wrong.append)
    assert len(done) >= 60
    assert not wrong, "\n".join(wrong)
