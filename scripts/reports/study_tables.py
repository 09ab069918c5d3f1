"""The tables of `activesuit reproduce li-2022`, as rows for CSV files and as rows of text."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ...hysteresis.jiles_atherton import PARAMETERS
from ...identification.study.summary import Judgement, Summary
from ...identification.study.trial import StudyConfig
from ..output import Rows

QUARTILES = ("q1", "median", "q3")
NO_CURVE = ("", "")  # cells of a held-out curve that a joint does not have


def trial_rows(
    config: StudyConfig, summaries: Sequence[Summary]
) -> tuple[list[str], list[list[Any]]]:
    """Returns one row per trial; every held-out curve of any joint has its own columns."""
    held_out = sorted({name for summary in summaries for name in summary.best.predictions})
    header = ["joint", "method", "trial", *PARAMETERS, "fitness", "nrmse", "evaluations"]
    header += ["convergence_iteration", "evaluations_to_target"]
    header += [cell for name in held_out for cell in (f"max_error_{name}_nm", f"nrmse_{name}")]
    rows = []
    for summary in summaries:
        for trial, reached in zip(summary.trials, summary.evaluations_to_target, strict=True):
            converged = summary.convergence is not None
            rows.append(
                [
                    *trial.key,
                    *trial.parameters,
                    trial.fitness,
                    trial.nrmse,
                    trial.evaluations,
                    trial.convergence_iteration(config.swarm_size) if converged else "",
                    int(reached) if np.isfinite(reached) else "",
                    *(e for name in held_out for e in trial.predictions.get(name, NO_CURVE)),
                ]
            )
    return header, rows


def summary_rows(summaries: Sequence[Summary]) -> tuple[list[str], list[list[Any]]]:
    """Returns one row per joint and method: its best trial, and the quartiles over all trials."""
    held_out = sorted({name for summary in summaries for name in summary.predictions})
    header = ["joint", "method", "trials", "noise_floor", "best_trial", *PARAMETERS]
    header += ["best_fitness", "best_nrmse", *(f"best_max_error_{name}_nm" for name in held_out)]
    quantities = ["fitness", "nrmse", "convergence_iteration", "evaluations_to_target"]
    quantities += [f"max_error_{name}_nm" for name in held_out]
    quantities += ["multi_order_max_error_nm", "multi_order_nrmse", "first_order_nrmse"]
    quantities += ["multi_order_ratio"]
    header += ["successes", *(f"{name}_{q}" for name in quantities for q in QUARTILES)]
    header += ["multi_order_as_well"]
    rows = []
    for summary in summaries:
        best = summary.best
        spreads = [summary.fitness, summary.nrmse, summary.convergence, summary.to_target]
        spreads += [summary.predictions.get(name) for name in held_out]
        multi = summary.multi_order
        spreads += (
            [multi.largest, multi.nrmse, multi.first_order, multi.ratio] if multi else [None] * 4
        )
        rows.append(
            [
                summary.joint,
                summary.method,
                len(summary.trials),
                summary.noise,
                best.key.number,
                *best.parameters,
                best.fitness,
                best.nrmse,
                *(best.predictions.get(name, NO_CURVE)[0] for name in held_out),
                summary.successes,
                *(v for spread in spreads for v in (("",) * 3 if spread is None else spread)),
                "" if multi is None else multi.as_well,
            ]
        )
    return header, rows


def best_table(summaries: Iterable[Summary]) -> Rows:
    """Returns Table 2 of the paper for our data: the best trials; a, alpha and k in degrees."""
    header = ["joint", "method", "Ms\n[N·m]", "a\n[deg]", "alpha\n[deg/N·m]", "c", "k\n[deg]"]
    header += ["fitness,\neq. (7)", "NRMSE"]
    rows = []
    for summary in summaries:
        best = summary.best
        rows.append(
            [
                summary.joint,
                summary.method,
                *(f"{value:.4g}" for value in best.parameters),
                f"{best.fitness:.3e}",
                f"{best.nrmse:.2%}",
            ]
        )
    return header, rows


def typical_table(summaries: Iterable[Summary]) -> Rows:
    """Returns the fitness, the success rate and the speed of each method: median and quartiles."""
    header = ["joint", "method", "fitness,\nmedian", "quartiles", "success"]
    header += ["converged\nat", "runs to\ntarget"]
    rows = []
    for summary in summaries:
        low, middle, high = summary.fitness
        convergence = summary.convergence
        rows.append(
            [
                summary.joint,
                summary.method,
                f"{middle:.2e}",
                f"{low:.2e} to\n{high:.2e}",
                f"{summary.success_rate:.0%}",
                "-" if convergence is None else "{1:.0f} ({0:.0f}-{2:.0f})".format(*convergence),
                f"{summary.to_target[1]:,.0f}" if np.isfinite(summary.to_target[1]) else "-",
            ]
        )
    return header, rows


def prediction_table(summaries: Iterable[Summary]) -> Rows:
    """Returns the largest error [N·m] on each held-out curve: best trial, median and quartiles."""
    header = ["joint", "method", "held-out\ncurve", "best trial\n[N·m]", "median\n[N·m]"]
    header += ["quartiles\n[N·m]"]
    rows = []
    for summary in summaries:
        for name, (low, middle, high) in summary.predictions.items():
            best = summary.best.predictions[name].largest
            numbers = [_finite(best), _finite(middle), f"{_finite(low)} to {_finite(high)}"]
            rows.append([summary.joint, summary.method, name, *numbers])
    return header, rows


def multi_order_table(summaries: Iterable[Summary]) -> Rows:
    """Returns the median errors on held-out motions of many turns, beside first-order curves."""
    header = ["joint", "method", "largest error\n[N·m]", "NRMSE", "NRMSE,\nfirst-order"]
    header += ["ratio,\nquartiles", "as well"]
    rows = []
    for summary in summaries:
        multi = summary.multi_order
        if multi is None:
            continue
        ratio = "{1:.2f} ({0:.2f}-{2:.2f})".format(*multi.ratio)
        as_well = f"{multi.as_well / len(summary.trials):.0%}"
        compared = not np.isnan(multi.first_order).any()
        rows.append(
            [
                summary.joint,
                summary.method,
                _finite(multi.largest[1]),
                _percent(multi.nrmse[1]),
                *([_percent(multi.first_order[1]), ratio, as_well] if compared else ["-"] * 3),
            ]
        )
    return header, rows


def verdict_table(judgements: Iterable[Judgement]) -> Rows:
    """Returns one row per claim of the paper, with our result beside it."""
    header = ["joint", "SA-PSO better in", "printed", "verdict", "medians,\nSA-PSO / MPSO"]
    header += ["advantage", "95 % interval"]
    rows = []
    for ours in judgements:
        claim = ours.claim
        if ours.reason:
            numbers = ["-", "-", "-"]
        else:
            numbers = [
                f"{ours.sa_pso:.4g} /\n{ours.mpso:.4g}",
                f"{ours.advantage:+.1%}",
                f"{ours.interval[0]:+.1%} to\n{ours.interval[1]:+.1%}",
            ]
        printed = f"{claim.advantage:+.2%}" if claim.advantage else "better"
        rows.append([claim.joint, claim.quantity, printed, ours.verdict, *numbers])
    return header, rows


def _finite(error: float) -> str:
    return f"{error:.2f}" if np.isfinite(error) else "pole"


def _percent(error: float) -> str:
    return "-" if np.isnan(error) else f"{error:.2%}" if np.isfinite(error) else "pole"
