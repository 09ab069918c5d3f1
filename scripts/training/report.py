"""The report of a training: the learning curve, what the best policy gives, each evaluation."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ...envs.policies.network import Card
from ..html.writing import write_report
from .evaluations import Evaluations, relief_text, value
from .run import Run

Results = Sequence[Mapping[str, Any]]
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c564b")
LINES = {"none": ("0.55", ":"), "compensation": ("0.25", "--")}  # policies that do not learn
SCALE = {0.0: "suit alone", 1.0: "no suit"}  # what a relief means
COLUMNS = {  # of an evaluation, as columns of the table
    "success": ("success", "{:.0%}"),
    "effort": ("effort\n[% of strength]", "{:.1%}"),
    "tracking": ("tracking error\n[rad]", "{:.3f}"),
    "saturated": ("motor saturated\n[% of time]", "{:.1%}"),
}


def write_report_of(run: Run, done: int, evaluations: Evaluations, name: str) -> None:
    """Writes the learning curve of a training and its report, which says that it has ended.

    Args:
        run: The run.
        done: Steps of the training.
        evaluations: Its evaluations.
        name: Name of the learning curve.
    """
    card, results = run.card, evaluations.results
    if evaluations.wanted:
        run.folder.figure("learning_curve", learning_figure({name: results}, evaluations.beside))
    header = ["steps", "relief,\n95 % interval", *(title for title, _ in COLUMNS.values())]
    rows = [
        [str(one["steps"]), relief_text(one["relief"])]
        + [form.format(one[name]) if name in one else "-" for name, (_, form) in COLUMNS.items()]
        for one in results
    ]
    title = f"{card.training['algo']} on {card.environment['env']}, {done} steps"
    write_report(
        *(run.folder, "train", title),
        answer=_answer(card, done, results),
        tables={"Evaluations during the training": (header, rows)} if results else {},
        settings={"environment": card.environment, "training": card.training},
    )


def advice(card: Card, results: Results) -> Iterator[str]:
    """Yields what to do where even the best policy costs the wearer effort.

    Args:
        card: Card of the policy.
        results: Results of the evaluations.
    """
    relief = max(results, key=value)["relief"] if results else None
    if relief is None or relief["value"] >= 0:
        return
    begin = "begin with --residual compensation"
    if card.residual is not None:
        begin = "begin with less exploration (log_std_init) or a smaller --residual-scale"
    yield (
        f"This policy costs the wearer more than the suit without an exoskeleton does (relief "
        f"{relief['value']:.2f}): {begin}, or train for more steps."
    )


def _answer(card: Card, done: int, results: Results) -> Iterator[str]:
    if not results:
        yield f"A policy was trained for {done} steps, and not evaluated."
        return
    best, gives = max(results, key=value), "no relief, as it loses arms or the suit costs nothing"
    if best["relief"] is not None:
        gives = f"a relief of {relief_text(best['relief'])}"
    yield (
        f"The best policy, after {best['steps']} of {done} steps, has {gives}, and succeeds in "
        f"{best['success']:.0%} of {card.training['motions']} motions that are in no training."
    )
    yield from advice(card, results)
    yield (
        "Relief is the share of the suit's cost in effort that adapted wearers get back: 0 is the "
        "suit without an exoskeleton, 1 is no suit."
    )


def learning_figure(
    curves: Mapping[str, Results],
    beside: Mapping[str, Mapping[str, float] | None],
) -> Figure:
    """Draws relief over steps, with the interval of each evaluation as a band.

    Args:
        curves: Results of the evaluations of each training, by its label: `steps`, and `relief`
            with `value`, `low` and `high`, or None.
        beside: Relief of policies that do not learn, in the same form, by their names in LINES.
    """
    figure = Figure(figsize=(7, 4), layout="constrained")
    ax = figure.subplots()
    for i, (label, results) in enumerate(curves.items()):
        shown = [one for one in results if one["relief"]]
        steps = np.array([one["steps"] for one in shown])
        values, low, high = (
            np.array([one["relief"][part] for one in shown]) for part in ("value", "low", "high")
        )
        color = COLORS[i % len(COLORS)]
        ax.fill_between(steps, low, high, color=color, alpha=0.15, lw=0)
        ax.plot(steps, values, color=color, marker="o", ms=3, lw=1.3, label=label)
    for name, relief in beside.items():
        if relief is not None and name in LINES:
            color, style = LINES[name]
            ax.axhspan(relief["low"], relief["high"], color=color, alpha=0.12, lw=0)
            ax.axhline(relief["value"], color=color, lw=1.2, ls=style, label=name)
    for height, meaning in SCALE.items():
        ax.axhline(height, color="0.7", lw=0.8)
        ax.text(0.99, height, meaning, transform=ax.get_yaxis_transform(), va="bottom", ha="right")
    ax.set(xlabel="steps of the training", ylabel="relief of adapted wearers")
    ax.legend(frameon=False, loc="best")
    ax.grid(alpha=0.25)
    return figure
