"""The benchmark of controllers: suites of tasks, levels and suits, their trials and tables."""

from .results import Result, read_results
from .suite import BASELINE, SUITES, Setting, Suite, Trial, suite
from .trial import run_trial

__all__ = [
    "BASELINE",
    "SUITES",
    "Result",
    "Setting",
    "Suite",
    "Trial",
    "read_results",
    "run_trial",
    "suite",
]
