"""Figures of measured and modeled loops. A figure function takes data and returns the figure."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from .curves import Curve, Curves
from .identify import Fit
from .thinning import drawn_note, drawn_samples

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
STYLES = ("-", "--", ":", "-.")


def loops_figure(
    families: Mapping[str, Sequence[Curve]], fits: Mapping[str, Mapping[str, Fit]]
) -> Figure:
    """Draws the measured loops of each joint and the torque of each fit.

    Args:
        families: Curves by joint name; fitted and predicted ones get a column each, if there are
            any.
        fits: Joint name -> label -> fit.

    Returns:
        One row per joint: fitted curves on the left, predicted ones on the right.
    """
    columns = 2 if any(Curves(curves).held_out() for curves in families.values()) else 1
    figure = Figure(figsize=(5 * columns, 3.8 * len(families)), layout="constrained")
    grid = figure.subplots(len(families), columns, squeeze=False, sharey="row")
    for axes, (joint, curves) in zip(grid, families.items(), strict=True):
        parts = {"fitted": Curves(curves).fitted()}
        if columns == 2:
            parts["predicted"] = Curves(curves).held_out()
        for ax, (title, drawn) in zip(axes, parts.items(), strict=True):
            _draw_loops(ax, drawn, fits[joint])
            ax.set_title(f"{joint.replace('_', ' ')}, {title}", loc="left")
            note = drawn_note(drawn)
            ax.set_xlabel(f"angle [rad] ({note})" if note else "angle [rad]")
        tare = next(iter(fits[joint].values())).tare
        less = f", {tare:.3g} N·m of the sensor taken off" if tare else ""
        axes[0].set_ylabel(f"resistance [N·m]{less}")
    grid[0][0].legend(loc="upper left", frameon=False)
    return figure


def _draw_loops(ax, curves: Sequence[Curve], fits: Mapping[str, Fit]) -> None:
    for i, (curve, drawn) in enumerate(zip(curves, drawn_samples(curves), strict=True)):
        angle = curve.angle[drawn]
        ax.plot(
            angle,
            curve.torque[drawn],
            ".",
            color="0.75",
            markersize=3,
            label="curves" if i == 0 else None,
            zorder=0,
        )
        for (label, fit), color, style in zip(fits.items(), COLORS, STYLES, strict=False):
            ax.plot(
                angle,
                fit.predict(curve)[drawn],  # torque along all samples, which the memory needs
                style,
                color=color,
                lw=1.4,
                label=label if i == 0 else None,
            )
    ax.axhline(0, color="0.6", lw=0.6)
    ax.grid(alpha=0.25)


def convergence_figure(histories: Mapping[str, Mapping[str, Sequence[Sequence[float]]]]) -> Figure:
    """Draws the best fitness over iterations: median of the trials, and their quartiles.

    Args:
        histories: Joint name -> method -> one history per trial.
    """
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    axes = figure.subplots(1, len(histories), squeeze=False, sharey=True)[0]
    for ax, (joint, methods) in zip(axes, histories.items(), strict=True):
        for (label, runs), color in zip(methods.items(), COLORS, strict=False):
            quartiles = np.percentile(np.array(runs), [25, 50, 75], axis=0)
            iteration = np.arange(quartiles.shape[1])
            ax.fill_between(iteration, quartiles[0], quartiles[2], color=color, alpha=0.2, lw=0)
            ax.plot(iteration, quartiles[1], color=color, label=label)
        ax.set(yscale="log", xlabel="iteration", title=joint.replace("_", " "))
        ax.grid(alpha=0.25, which="both")
    axes[0].set_ylabel("fitness, eq. (7): median and quartiles")
    axes[0].legend(frameon=False)
    return figure
