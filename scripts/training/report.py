"""The report of a training: learning curve, relief of the best policy, and all evaluations."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ...envs.policies.network import Card
from ...plots import Band, Line, Mark, Panel, Plot
from ..writer import Report, write
from .evaluations import Evaluations, relief_text, value
from .run import Run, asked

Results = Sequence[Mapping[str, Any]]
LEVELS = {"suit alone": 0.0, "no suit": 1.0}  # meanings of the relief
COLUMNS = {  # of an evaluation, as columns of the table
    "success": ("success", "{:.0%}"),
    "effort": ("effort\n[% of strength]", "{:.1%}"),
    "tracking": ("tracking error\n[rad]", "{:.3f}"),
    "saturated": ("motor saturated\n[% of time]", "{:.1%}"),
}


def write_report_of(run: Run, done: int, evaluations: Evaluations, name: str) -> None:
    """Writes the report of a finished training, with its learning curve."""
    card, results = run.card, evaluations.results
    header = ["steps", "relief,\n95 % interval", *(title for title, _ in COLUMNS.values())]
    rows = [
        [str(one["steps"]), relief_text(one["relief"])]
        + [form.format(one[name]) if name in one else "-" for name, (_, form) in COLUMNS.items()]
        for one in results
    ]
    curve = {"learning_curve": learning_plot({name: results}, evaluations.beside)}
    report = Report(
        heading="Trained policy",
        about=f"{card.training['algo']} on {card.environment['env']}, {done} steps",
        result={
            **{"steps": done, "asked": asked(card.training)},
            **{"evaluations": results, "beside": evaluations.beside},
        },
        tables={"Evaluations during the training": (header, rows)} if results else {},
        answer=[*_answer(card, done, results)],
        plots=curve if evaluations.wanted else {},
        settings={"environment": card.environment, "training": card.training},
    )
    write(report, run.folder)


def advice(card: Card, results: Results) -> Iterator[str]:
    """Yields advice if even the best policy costs the wearer effort."""
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


def learning_plot(
    curves: Mapping[str, Results],
    beside: Mapping[str, Mapping[str, float] | None],
) -> Plot:
    """Returns the plot of relief over steps, with a band for the intervals of the evaluations.

    `curves` has results of evaluations by the label of the training, and `beside` the relief of
    policies that do not learn, by name. A relief has `value`, `low` and `high`, or is None.
    """
    known = {label: [one for one in found if one["relief"]] for label, found in curves.items()}
    ends = {one["steps"] for found in known.values() for one in found}
    marks: list[Mark] = []
    for name, relief in beside.items():
        if relief is not None and ends:
            steps = [min(ends | {0}), max(ends)]
            low, value, high = ([relief[part]] * 2 for part in ("low", "value", "high"))
            marks += [Band(steps, low, high, name), Line(steps, value, name, dash="dash")]
    for label, found in known.items():
        steps = [one["steps"] for one in found]
        low, value, high = (
            [one["relief"][part] for one in found] for part in ("low", "value", "high")
        )
        marks += [Band(steps, low, high, label), Line(steps, value, label)]
    panel = Panel(
        x="steps of the training", y="relief of adapted wearers", marks=marks, levels=LEVELS
    )
    return Plot(title="Relief of adapted wearers during the training", panels=[panel], height=4)
