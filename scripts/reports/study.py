"""The report of `activesuit reproduce li-2022`, as text and as plain values for JSON."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...hysteresis.jiles_atherton import PARAMETERS
from ...identification.diagnostics import NEAR
from ...identification.study.summary import AS_WELL, Judgement, MultiOrder, Summary
from ...identification.study.trial import StudyConfig
from ...published import LI_BOUNDS
from ..output import markdown_table
from .study_tables import (
    QUARTILES,
    best_table,
    multi_order_table,
    prediction_table,
    typical_table,
    verdict_table,
)


def to_dict(
    config: StudyConfig, summaries: Sequence[Summary], judgements: Sequence[Judgement]
) -> dict[str, Any]:
    """Returns the result of the study as plain values for JSON, without its single trials."""
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
        "## Largest errors on held-out first-order curves",
        markdown_table(*prediction_table(summaries)),
        "Successful trials: "
        + "; ".join(f"{s.joint} {s.method} {s.successes} of {len(s.trials)}" for s in summaries)
        + ".",
        *_at_limits(summaries),
        *_multi_order_section(summaries),
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
            "being the first; the paper does not say what it means by convergence. It rewards "
            "stagnation: a swarm that stops improving early converges early, however bad it is"
        ),
        "success": (
            "NRMSE within 5 % of the noise floor, which is estimated from the curves' second "
            "differences"
        ),
        "runs to target": (
            "median number of model evaluations until success, over all trials; '-' if fewer than "
            "half of them succeeded"
        ),
        "largest error": (
            "largest |Tc - Tm| on each curve with role predict, the curve's own noise included"
        ),
        "ratio": (
            "a trial's NRMSE over all held-out motions that turn more than once, by that over the "
            "held-out first-order curves; both relative to the largest torque of the fitted curves"
        ),
        "as well": f"trials whose ratio is at most {AS_WELL}",
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


def _multi_order_section(summaries: Sequence[Summary]) -> list[str]:
    if not any(summary.multi_order for summary in summaries):
        return []
    return [
        "## Held-out motions that turn more than once",
        "Does a model that is identified on first-order curves predict motions of many turns as "
        "well as first-order ones?",
        markdown_table(*multi_order_table(summaries)),
        "\n".join(filter(None, map(_answer, summaries))),
    ]


def _answer(summary: Summary) -> str:
    multi = summary.multi_order
    if multi is None or np.isnan(multi.first_order[1]):
        return ""
    words = "as well" if multi.ratio[1] <= AS_WELL else "worse"
    return (
        f"- {summary.joint}, {summary.method}: **{words}**. The error is {multi.ratio[1]:.2f} "
        f"({multi.ratio[0]:.2f} to {multi.ratio[2]:.2f}) times that on first-order curves; in "
        f"{multi.as_well} of {len(summary.trials)} trials it is at most {AS_WELL - 1:.0%} larger."
    )


def _at_limits(summaries: Iterable[Summary]) -> list[str]:
    found = []
    for summary in summaries:
        if summary.method == "certified":
            continue
        names = [
            name
            for name, value, pair in zip(
                PARAMETERS, summary.best.parameters, LI_BOUNDS, strict=True
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
            "predictions": {
                name: errors._asdict() for name, errors in summary.best.predictions.items()
            },
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
        "multi_order": _multi_order_dict(summary.multi_order),
    }


def _multi_order_dict(multi: MultiOrder | None) -> dict[str, Any] | None:
    return multi and {
        name: dict(zip(QUARTILES, value, strict=True)) if isinstance(value, np.ndarray) else value
        for name, value in asdict(multi).items()
    }
