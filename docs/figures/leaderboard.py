"""Draws the share of motions with at least a relief, from the committed results."""

from pathlib import Path

import activesuit
from activesuit.envs.benchmark import Leaderboard, read_results

RESULTS = Path(activesuit.__path__[0], "docs", "leaderboard.jsonl")
figure = Leaderboard(read_results([RESULTS])).plots()["profiles"].figure()
figure.savefig("leaderboard.png", dpi=110)
