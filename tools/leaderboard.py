"""Makes docs/leaderboard.md from results: `python -m activesuit.tools.leaderboard`.

Further results, of `activesuit benchmark run`, are merged into those that are committed:
`python -m activesuit.tools.leaderboard runs/full runs/tuned`.
"""

import sys
from pathlib import Path

from ..envs.benchmark import Leaderboard
from ..envs.benchmark.results import lines, read_results
from ..files import write_text

DOCS = Path(__file__).parent.parent / "docs"
RESULTS, PAGE = DOCS / "leaderboard.jsonl", DOCS / "leaderboard.md"
FIGURE = DOCS / "figures" / "leaderboard.png"
TITLE = "# Leaderboard"


def leaderboard(results: Path = RESULTS) -> str:
    """Returns the page of a file of results."""
    return Leaderboard(read_results([results])).page(TITLE, f"figures/{FIGURE.name}")


def main() -> None:
    """Merges the results that are given, and writes page and figure."""
    given = [Path(path) for path in sys.argv[1:]]
    kept = [RESULTS] if RESULTS.exists() else []
    found = read_results([*kept, *given])
    write_text(RESULTS, lines(found))
    write_text(PAGE, leaderboard())
    Leaderboard(found).plots()["profiles"].figure().savefig(FIGURE, dpi=110)


if __name__ == "__main__":
    main()
