"""Learning curves: relief of adapted wearers over the steps of trainings."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure

Results = Sequence[Mapping[str, Any]]
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c564b")


def learning_figure(curves: Mapping[str, Results]) -> Figure:
    """Draws relief over steps, with the interval of each evaluation as a band.

    Args:
        curves: Results of the evaluations of each training, by its label: `steps`, and `relief`
            with `value`, `low` and `high`, or None.
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
    for height, meaning in ((0, "suit alone"), (1, "no suit")):
        ax.axhline(height, color="0.4", lw=0.8, ls=":")
        ax.annotate(
            meaning,
            (1, height),
            xycoords=("axes fraction", "data"),
            xytext=(-2, 2),
            textcoords="offset points",
            ha="right",
            fontsize=8,
            color="0.35",
        )
    ax.set_xlabel("steps of the training")
    ax.set_ylabel("relief of adapted wearers")
    ax.legend(frameon=False, loc="best")
    ax.grid(alpha=0.25)
    return figure


BESIDE = {
    "compensation": ("0.45", "--"),
    "adaptive": ("0.2", "-."),
    "best-known-plan": ("0.2", ":"),
}
MARGIN = 0.15  # of the range of means, above and below
MUCH_LONGER = 4  # times as many steps


def study_figure(
    curves: Sequence[Mapping[str, Any]], beside: Sequence[Mapping[str, Any]]
) -> Figure:
    """Draws learning curves of ways of training, a panel for each task and level.

    Args:
        curves: Relief of a way of training at some steps: `task`, `level`, `way`, `steps`, `value`,
            and `low` and `high` where there is an interval.
        beside: Relief of policies that do not learn: `task`, `level`, `policy` and
            `in_training`, in the motions of the curves, or None where they lose arms.

    Panels show all means; an interval beyond them is cut at the frame. Steps are logarithmic where
    the trainings of one way are much longer than those of another.
    """
    tasks, levels = (
        list(dict.fromkeys(one[name] for one in (*curves, *beside))) for name in ("task", "level")
    )
    ways = list(dict.fromkeys(one["way"] for one in curves))
    shape = (len(tasks), len(levels))
    figure = Figure(figsize=(3.4 * shape[1] + 1, 2.6 * shape[0] + 0.8), layout="constrained")
    axes = figure.subplots(*shape, squeeze=False, sharex=True)
    ends = [max(one["steps"] for one in curves if one["way"] == way) for way in ways]
    for ax, (task, level) in zip(axes.flat, product(tasks, levels), strict=True):
        means = []
        for i, way in enumerate(ways):
            names = {"task": task, "level": level, "way": way}
            points = [one for one in curves if names.items() <= one.items()]
            steps, value, low, high = (
                np.array([one.get(part, one["value"]) for one in points])
                for part in ("steps", "value", "low", "high")
            )
            color = COLORS[i % len(COLORS)]
            means += [*value]
            ax.fill_between(steps, low, high, color=color, alpha=0.15, lw=0)
            ax.plot(steps, value, color=color, lw=1.3, label=way)
        for one in beside:
            if (one["task"], one["level"]) == (task, level) and one["in_training"] is not None:
                name = one["policy"].partition(":")[0]
                means.append(one["in_training"])
                color, style = BESIDE[name]
                ax.axhline(one["in_training"], color=color, ls=style, lw=1, label=name)
        if means:
            margin = MARGIN * (max(means) - min(means)) or MARGIN
            ax.set_ylim(min(means) - margin, max(means) + margin)
        ax.set_title(f"{task}, {level}", fontsize=9)
        ax.grid(alpha=0.25)
    if ends and max(ends) > MUCH_LONGER * min(ends):
        axes[0, 0].set_xscale("log")
    for ax in axes[-1]:
        ax.set_xlabel("steps")
    for ax in axes[:, 0]:
        ax.set_ylabel("relief")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper center", ncols=3 * shape[1], frameon=False, fontsize=8
    )
    return figure
