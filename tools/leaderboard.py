"""Makes docs/numbers/leaderboard.md from results: `python -m activesuit.tools.leaderboard`.

Further results, of `activesuit benchmark run`, are merged into those that are committed:
`python -m activesuit.tools.leaderboard runs/full runs/tuned`.
"""

import sys
from pathlib import Path

from ..envs.benchmark import Leaderboard
from ..envs.benchmark.results import lines, read_results
from ..files import write_text

DOCS = Path(__file__).parent.parent / "docs"
RESULTS, PAGE = DOCS / "leaderboard.jsonl", DOCS / "numbers" / "leaderboard.md"


def leaderboard() -> str:
    """Returns the page of the committed results."""
    return Leaderboard(read_results([RESULTS])).page("# Leaderboard", "../figures/leaderboard.png")


def main() -> None:
    """Merges the results that are given, and writes the page."""
    found = read_results([RESULTS, *map(Path, sys.argv[1:])])
    write_text(RESULTS, lines(found))
    write_text(PAGE, leaderboard())


if __name__ == "__main__":
    main()
