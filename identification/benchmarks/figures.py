"""Figures 6, 7 and 8 of Kao and Fung (2009) in our data."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...arrays import Array
from .dispatch import OPTIMUM, RELAXED_OPTIMUM

COLORS = {"pso": "#d55e00", "rank-distance-mpso": "#0072b2"}
LABELS = {"pso": "PSO", "rank-distance-mpso": "rank-distance MPSO"}
STYLES = {"pso": "-", "rank-distance-mpso": "--"}


def cost_figure(histories: Mapping[bool, Mapping[str, Sequence[Array]]]) -> Figure:
    """Draws the cost above the optimum over iterations: figure 6.

    Args:
        histories: Whether the slack limit is relaxed -> method -> best cost [$/h] of each trial
            before the first and after each iteration.
    """
    figure, axes = _row(len(histories))
    for ax, (relaxed, methods) in zip(axes, histories.items(), strict=True):
        optimum = RELAXED_OPTIMUM if relaxed else OPTIMUM
        for method, runs in methods.items():
            above = np.array(runs) - optimum
            iteration = np.arange(above.shape[1])
            low, high = np.percentile(above, [25, 75], axis=0)
            color = COLORS[method]
            ax.fill_between(iteration, low, high, color=color, alpha=0.2, lw=0)
            ax.plot(iteration, above.mean(axis=0), STYLES[method], color=color)
            ax.plot(iteration, np.median(above, axis=0), STYLES[method], color=color, lw=0.8)
            ax.plot([], [], STYLES[method], color=color, label=LABELS[method])
        name = "limit of unit 2 ignored" if relaxed else "all limits kept"
        ax.set_title(f"{name}: optimum {optimum:.4f} $/h", loc="left", fontsize=10)
        ax.set_yscale("symlog", linthresh=1e-2)
        ax.set_xlabel("iteration")
    highest = max(
        np.percentile(runs, 75, axis=0).max() for it in histories.values() for runs in it.values()
    )
    axes[0].set_ylim(0, 2 * (highest - RELAXED_OPTIMUM))
    axes[0].set_ylabel("cost above the optimum [$/h]\nmean (thick), median (thin), quartiles")
    axes[0].legend(frameon=False, loc="upper right")
    return figure


def error_figure(time: Array, errors: Mapping[str, Mapping[str, Array]], noise: float) -> Figure:
    """Draws measured less simulated displacement over time: figure 7.

    Args:
        time: Instants [s], (samples,).
        errors: Case -> method -> error [m], (samples,).
        noise: Standard deviation of the measurement's noise [m].
    """
    figure = Figure(figsize=(10, 5.6), layout="constrained")
    grid = figure.subplots(2, len(errors), squeeze=False, sharex=True, sharey="row")
    for column, (case, methods) in zip(grid.T, errors.items(), strict=True):
        for method, error in methods.items():
            style = {"color": COLORS[method], "lw": 0.9, "label": LABELS[method]}
            column[0].plot(time, error * 1e9, STYLES[method], **style)
        first, *others = methods
        for other in others:
            difference = (methods[other] - methods[first]) * 1e9
            column[1].plot(time, difference, color="0.3", lw=1)
        column[0].axhspan(-noise * 1e9, noise * 1e9, color="0.85", lw=0, label="noise, one std")
        column[0].set_title(case, loc="left")
        column[1].set_xlabel("time [s]")
        for ax in column:
            ax.grid(alpha=0.25)
    grid[0][0].set_ylabel("measured - simulated x [nm]")
    grid[1][0].set_ylabel("PSO's x - MPSO's x [nm]")
    grid[0][0].legend(frameon=False, loc="upper center", ncols=3, fontsize=8)
    low, high = grid[0][0].get_ylim()
    grid[0][0].set_ylim(low, high + 0.2 * (high - low))
    return figure


def convergence_figure(histories: Mapping[str, Mapping[str, Array]], floor: float) -> Figure:
    """Draws the sum of squared errors, eq. (10), over iterations: figure 8.

    Args:
        histories: Case -> method -> best sum [m^2] before the first and after each iteration.
        floor: The sum at the true parameters [m^2].
    """
    figure, axes = _row(len(histories))
    for ax, (case, methods) in zip(axes, histories.items(), strict=True):
        for method, history in methods.items():
            ax.plot(history * 1e12, STYLES[method], color=COLORS[method], label=LABELS[method])
        ax.axhline(floor * 1e12, color="0.4", lw=0.9, ls=":", label="at the true parameters")
        ax.set_title(case, loc="left")
        ax.set_xlabel("iteration")
    # As in the paper, the axis leaves out the first drop, beside which nothing else could be seen.
    lowest = min(history.min() for it in histories.values() for history in it.values())
    span = max(floor - lowest, 0.02 * floor)
    axes[0].set_ylim((lowest - 0.3 * span) * 1e12, (floor + 3 * span) * 1e12)
    axes[0].set_ylabel("sum of squared errors, eq. (10) [µm²]")
    axes[0].legend(frameon=False, loc="upper right")
    return figure


def _row(panels: int) -> tuple[Figure, Sequence[Axes]]:
    figure = Figure(figsize=(10, 3.8), layout="constrained")
    axes = figure.subplots(1, panels, squeeze=False, sharey=True)[0]
    for ax in axes:
        ax.grid(alpha=0.25)
    return figure, axes
