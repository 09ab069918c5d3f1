"""A few kills at random moments; `python tests/kills.py --count 60` does many of all commands."""

import pytest
from kills import QUICK, attack


@pytest.mark.slow
def test_kills_leave_nothing_half(capsys):
    told = []
    assert attack(QUICK, 3, seed=1, say=told.append) == 0, "\n".join(told)
