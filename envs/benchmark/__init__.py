"""The benchmark of controllers: suites of tasks, levels and suits, their trials and tables."""

from .report import Benchmark
from .results import Result, read_results, run_trial
from .suite import BASELINE, SUITES, Setting, Suite, Trial, suite

__all__ = [
    "BASELINE",
    "SUITES",
    "Benchmark",
    "Result",
    "Setting",
    "Suite",
    "Trial",
    "read_results",
    "run_trial",
    "suite",
]
