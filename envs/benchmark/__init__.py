"""The benchmark of controllers: suites of tasks, levels and suits, their trials and tables."""

from .leaderboard import Leaderboard
from .results import Result, read_results, run_trial
from .suites import BASELINE, SUITES, Setting, Suite, Trial, suite

__all__ = [
    "BASELINE",
    "SUITES",
    "Leaderboard",
    "Result",
    "Setting",
    "Suite",
    "Trial",
    "read_results",
    "run_trial",
    "suite",
]
