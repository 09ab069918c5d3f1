"""The report of a training: what the best policy gives, and each evaluation."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ...envs.policies.network import Card
from ..html.writing import write_report
from ..output import Rows, RunFolder
from .evaluations import relief_text, value

COLUMNS = {  # what `physical` returns, as columns of the table
    "success": ("success", "{:.0%}"),
    "effort": ("effort\n[% of strength]", "{:.1%}"),
    "tracking": ("tracking error\n[rad]", "{:.3f}"),
    "saturated": ("motor saturated\n[% of time]", "{:.1%}"),
}


def write_training_page(
    folder: RunFolder, card: Card, done: int, results: Sequence[Mapping[str, Any]]
) -> None:
    """Writes the report of a training that is at its end.

    Args:
        folder: Folder of the run.
        card: Card of the policy.
        done: Steps of the training.
        results: Results of its evaluations; empty if there were none.
    """
    algorithm, env = card.training["algo"], card.environment["env"]
    write_report(
        *(folder, "train", f"{algorithm} on {env}, {done} steps"),
        answer=_answer(card, done, results),
        tables={"Evaluations during the training": _table(results)} if results else {},
        settings={"environment": card.environment, "training": card.training},
    )


def advice(card: Card, results: Sequence[Mapping[str, Any]]) -> Iterator[str]:
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


def _answer(card: Card, done: int, results: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    if not results:
        yield f"A policy was trained for {done} steps, and not evaluated."
        return
    best, motions = max(results, key=value), card.training.get("motions", 0)
    gives = "has no relief, as it loses arms or the suit costs nothing"
    if best["relief"] is not None:
        gives = f"has a relief of {relief_text(best['relief'])}"
    yield (
        f"The best policy, after {best['steps']} of {done} steps, {gives}, and succeeds in "
        f"{best['success']:.0%} of {motions} motions that are in no training."
    )
    yield from advice(card, results)
    yield (
        "Relief is the share of the suit's cost in effort that adapted wearers get back: 0 is the "
        "suit without an exoskeleton, 1 is no suit."
    )


def _table(results: Sequence[Mapping[str, Any]]) -> Rows:
    header = ["steps", "relief,\n95 % interval", *(title for title, _ in COLUMNS.values())]
    return header, [
        [str(one["steps"]), relief_text(one["relief"]), *_cells(one)] for one in results
    ]


def _cells(result: Mapping[str, Any]) -> Iterator[str]:
    for name, (_, form) in COLUMNS.items():
        yield form.format(result[name]) if name in result else "-"
