"""Learning curves: relief of adapted wearers over the steps of trainings."""

from collections.abc import Mapping, Sequence
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
