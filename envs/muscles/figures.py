"""Pictures of muscles: how active each one is over the time of a motion."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from ..evaluation.rollout import Trace
from .analysis import muscle_activation
from .myoarm import GROUPS, MyoArm

COLORS = "magma_r"
DARKEST = 99.5  # percentile of all activations that has the darkest color


def activation_figure(motions: Mapping[str, Trace]) -> Figure:
    """Draws activation over time as heat maps side by side, one a motion, muscles by group.

    Args:
        motions: The same intended motion under some conditions, by the name of each.
    """
    names = MyoArm.load().muscles
    rows = [names.index(name) for group in GROUPS.values() for name in group]
    found = {title: muscle_activation(motion) for title, motion in motions.items()}
    most = float(np.percentile(np.concatenate(list(found.values())), DARKEST))
    figure = Figure(figsize=(2.2 + 4.3 * len(motions), 7.2), layout="constrained")
    grid = figure.subplots(1, len(motions), sharey=True, squeeze=False)[0]
    shown = None
    for ax, (title, motion) in zip(grid, motions.items(), strict=True):
        shown = ax.imshow(
            found[title][:, rows].T,
            aspect="auto",
            vmin=0,
            vmax=most,
            cmap=COLORS,
            interpolation="nearest",
            extent=(0, motion.time[-1], len(rows) - 0.5, -0.5),
        )
        mean = np.sqrt(np.mean(found[title] ** 2))
        ax.set(title=f"{title}: root mean square {mean:.1%}", xlabel="time [s]")
        ends = np.cumsum([len(group) for group in GROUPS.values()])
        for end in ends[:-1]:
            ax.axhline(end - 0.5, color="0.4", lw=0.8)
    grid[0].set_yticks(range(len(rows)), [names[row] for row in rows], fontsize=7.5)
    begin = 0
    for name, group in GROUPS.items():
        middle = begin + (len(group) - 1) / 2
        grid[0].annotate(
            *(name.replace(" ", "\n"), (-0.17, middle)),
            xycoords=("axes fraction", "data"),
            ha="right",
            va="center",
            fontsize=9,
        )
        begin += len(group)
    figure.colorbar(shown, ax=grid, label="activation", extend="max", pad=0.01)  # pyright: ignore
    return figure
