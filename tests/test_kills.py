"""A kill at a random moment; `python tests/kills.py --count 60` does many of all commands."""

import pytest
from kills import QUICK, attack

SEED = 87  # KILL of a run in a new folder, late


@pytest.mark.slow
def test_kills_leave_nothing_half(capsys):
    reported = []
    assert attack(QUICK, 1, seed=SEED, say=reported.append) == 0, "\n".join(reported)
