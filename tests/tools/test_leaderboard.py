"""The leaderboard is what the command makes of the committed results."""

import pytest
from activesuit.tools.leaderboard import PAGE, leaderboard


@pytest.mark.slow
def test_the_page_is_made_from_the_results():
    assert PAGE.read_text(encoding="utf-8") == leaderboard()
