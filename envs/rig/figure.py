"""The figure of the curves that the rig measured."""

from collections.abc import Sequence

from matplotlib import colormaps
from matplotlib.figure import Figure

from .run import Record

COLORS = "viridis"


def records_figure(title: str, records: Sequence[Record]) -> Figure:
    """Draws the torque of each curve over its angle.

    Args:
        title: Title of the figure.
        records: Measured curves, drawn from dark to light.
    """
    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    ax = figure.subplots()
    colors = colormaps[COLORS].resampled(len(records) + 1)
    for i, record in reversed(list(enumerate(records))):
        ax.plot(record.angle, record.torque, color=colors(i), lw=0.9, label=record.name)
    ax.axhline(0, color="0.6", lw=0.6)
    ax.set(title=title, xlabel="angle [rad]", ylabel="resistance [N·m]")
    ax.legend(frameon=False)
    ax.grid(alpha=0.25)
    return figure
