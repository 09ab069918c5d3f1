"""The tables and the report of `activesuit study`, as rows and text."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..identification.remarks import NEAR
from ..identification.study import PAPER_BOUNDS, StudyConfig
from ..identification.study_summary import Judgement, Summary
from .output import markdown_table
from .tables import Rows

PARAMETERS = ("Ms", "a", "alpha", "c", "k")
QUARTILES = ("q1", "median", "q3")


def trial_rows(
    config: StudyConfig, summaries: Sequence[Summary]
) -> tuple[list[str], list[list[Any]]]:
    """One row per trial and, for what there are several of, one column each that any joint has."""
    held_out = sorted({name for summary in summaries for name in summary.predictions})
    header = ["joint", "method", "trial", *PARAMETERS, "fitness", "nrmse", "evaluations"]
    header += ["convergence_iteration", "evaluations_to_target"]
    header += [f"max_error_{name}_nm" for name in held_out]
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
                    *(trial.predictions.get(name, "") for name in held_out),
                ]
            )
    return header, rows


def summary_rows(summaries: Sequence[Summary]) -> tuple[list[str], list[list[Any]]]:
    """One row per joint and method: the best trial, then quartiles over all, in full precision."""
    held_out = sorted({name for summary in summaries for name in summary.predictions})
    header = ["joint", "method", "trials", "noise_floor", "best_trial", *PARAMETERS]
    header += ["best_fitness", "best_nrmse", *(f"best_max_error_{name}_nm" for name in held_out)]
    quantities = ["fitness", "nrmse", "convergence_iteration", "evaluations_to_target"]
    quantities += [f"max_error_{name}_nm" for name in held_out]
    header += ["successes", *(f"{name}_{q}" for name in quantities for q in QUARTILES)]
    rows = []
    for summary in summaries:
        best = summary.best
        spreads = [summary.fitness, summary.nrmse, summary.convergence, summary.to_target]
        spreads += [summary.predictions.get(name) for name in held_out]
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
                *(best.predictions.get(name, "") for name in held_out),
                summary.successes,
                *(v for spread in spreads for v in (("",) * 3 if spread is None else spread)),
            ]
        )
    return header, rows


def best_table(summaries: Iterable[Summary]) -> Rows:
    """Table 2 of the paper in our data: the best trials; a, alpha and k in degrees."""
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
    """How good, how sure and how fast each method is: medians with quartiles."""
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
    """The largest error [N·m] on each held-out curve: of the best trial, and over all."""
    header = ["joint", "method", "held-out\ncurve", "best trial\n[N·m]", "median\n[N·m]"]
    header += ["quartiles\n[N·m]"]
    rows = []
    for summary in summaries:
        for name, (low, middle, high) in summary.predictions.items():
            best = summary.best.predictions[name]
            numbers = [_finite(best), _finite(middle), f"{_finite(low)} to {_finite(high)}"]
            rows.append([summary.joint, summary.method, name, *numbers])
    return header, rows


def verdict_table(judgements: Iterable[Judgement]) -> Rows:
    """One row per claim of the paper, ours beside it."""
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


def to_dict(
    config: StudyConfig, summaries: Sequence[Summary], judgements: Sequence[Judgement]
) -> dict[str, Any]:
    """Returns the study's result as plain values for JSON, without the single trials."""
    return {
        **config.to_dict(),
        "definitions": _definitions(config),
        "summaries": [_summary_dict(summary) for summary in summaries],
        "claims": [asdict(judgement) for judgement in judgements],
    }


def report(
    config: StudyConfig,
    summaries: Sequence[Summary],
    judgements: Sequence[Judgement],
    drawn: Sequence[str],
) -> str:
    """Returns the report as Markdown."""
    parts = [
        "# Study of identification methods",
        f"{config.trials} trials of each method on each joint, seed {config.seed}; "
        f"{config.evaluations:,} model evaluations per trial ({config.swarm_size} x "
        f"{config.iterations + 1}) but for the certified fit, which stops by itself.",
        "## Best trials (Table 2 of the paper)",
        markdown_table(*best_table(summaries)),
        "## All trials",
        markdown_table(*typical_table(summaries)),
        "## Largest errors on held-out curves",
        markdown_table(*prediction_table(summaries)),
        "Successful trials: "
        + "; ".join(f"{s.joint} {s.method} {s.successes} of {len(s.trials)}" for s in summaries)
        + ".",
        *_at_limits(summaries),
        "## Definitions",
        "\n".join(f"- {name}: {text}" for name, text in _definitions(config).items()),
    ]
    if judgements:
        parts += ["## The paper's claims", _CLAIMS_NOTE, markdown_table(*verdict_table(judgements))]
        parts.append("\n".join(_sentence(judgement) for judgement in judgements))
    parts += ["## Figures", *(f"![{name}]({name}.png)" for name in drawn)]
    return "\n\n".join(parts) + "\n"


_CLAIMS_NOTE = (
    "Li et al. 2022, section 5, compare the best of 30 trials each; their measurements are not "
    "public and the shipped curves are synthetic, made from their SA-PSO parameters with 1 % "
    "noise, so what is judged is the comparison of the methods, not the data. An advantage is "
    "(MPSO - SA-PSO) / SA-PSO, as their 6.25 % = (51 - 48) / 48; over MPSO it would be 5.9, 16.9, "
    "12.6 and 31.7 %. Verdicts go by the medians of the trials: 'not reproduced' if the 95 % "
    "bootstrap interval lies below the printed number (below 0 where none is printed), else "
    "'reproduced' if it lies above 0, else 'undecidable'. The prediction is the mean of the "
    "largest errors on the held-out curves; the paper's own errors favor MPSO on one of four."
)


def _definitions(config: StudyConfig) -> dict[str, str]:
    return {
        "fitness": "eq. (7), sqrt(sum(((Tc - Tm) / max|Tm|)^2)) / N over the fitted curves",
        "converged at": (
            "the convergence iteration, the first whose best fitness is within 1 % of the trial's "
            f"final one; an iteration is {config.swarm_size} evaluations, the scattered swarm's "
            "being the first; "
            "the paper does not say what it means by convergence"
        ),
        "success": (
            "NRMSE within 5 % of the noise floor, which is estimated from the curves' second "
            "differences"
        ),
        "runs to target": (
            "median number of model evaluations until success, over all trials; '-' if fewer than "
            "half of them succeeded; a certified fit counts to its end"
        ),
        "largest error": (
            "largest |Tc - Tm| on each curve with role predict, the curve's own noise included"
        ),
    }


def _sentence(ours: Judgement) -> str:
    claim = ours.claim
    start = f"- {claim.joint}, {claim.quantity}: the paper says SA-PSO {claim.printed}. "
    if ours.reason:
        return f"{start}**Undecidable**: {ours.reason}."
    return (
        f"{start}**{ours.verdict.capitalize()}**: medians {ours.sa_pso:.4g} against "
        f"{ours.mpso:.4g}, an advantage of {ours.advantage:+.1%} ({ours.interval[0]:+.1%} to "
        f"{ours.interval[1]:+.1%}); of the best trials, {ours.best_advantage:+.1%}."
    )


def _at_limits(summaries: Iterable[Summary]) -> list[str]:
    found = []
    for summary in summaries:
        if summary.method == "certified":
            continue
        names = [
            name
            for name, value, pair in zip(
                PARAMETERS, summary.best.parameters, PAPER_BOUNDS, strict=True
            )
            if any(abs(value - limit) <= NEAR * max(1.0, abs(limit)) for limit in pair)
        ]
        if names:
            found.append(
                f"At a limit of the paper's search space: {', '.join(names)} of the best "
                f"{summary.method} trial on the {summary.joint}."
            )
    return found


def _summary_dict(summary: Summary) -> dict[str, Any]:
    return {
        "joint": summary.joint,
        "method": summary.method,
        "best": {
            "trial": summary.best.key.number,
            "parameters": dict(zip(PARAMETERS, summary.best.parameters, strict=True)),
            "fitness": summary.best.fitness,
            "nrmse": summary.best.nrmse,
            "prediction_max_error": summary.best.predictions,
        },
        "noise_floor": summary.noise,
        "successes": summary.successes,
        "success_rate": summary.success_rate,
        "fitness": dict(zip(QUARTILES, summary.fitness, strict=True)),
        "nrmse": dict(zip(QUARTILES, summary.nrmse, strict=True)),
        "convergence_iteration": None
        if summary.convergence is None
        else dict(zip(QUARTILES, summary.convergence, strict=True)),
        "evaluations_to_target": dict(zip(QUARTILES, summary.to_target, strict=True)),
        "prediction_max_error": {
            name: dict(zip(QUARTILES, values, strict=True))
            for name, values in summary.predictions.items()
        },
    }


def _finite(error: float) -> str:
    return f"{error:.2f}" if np.isfinite(error) else "pole"
