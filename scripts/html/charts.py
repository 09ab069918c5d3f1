"""Lines, points and axes as plotly takes them."""

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from ..text import visible

# They differ on white and on nearly black, also for most people who see few colors.
COLORS = (
    *("#2f86d0", "#d55e00", "#0f9d73", "#b565a7", "#d08700", "#3aa6c9", "#a0674b", "#7a6ad8"),
)
GRAY = "#8a8f98"
POINTS = 600  # greatest number of points of a line
ROW = 190  # [pixels], height of a row of axes
Figure = dict[str, Any]


def label(name: str) -> str:
    """Returns a name as plotly shows it as it is: plotly reads some HTML in texts."""
    return escape(visible(name.replace("\n", " ")), quote=False)


def thinned(samples: int, most: int = POINTS) -> NDArray[np.intp]:
    """Returns indices of at most about `most` samples at equal distances, and of the last one."""
    every = max(1, -(-samples // most))
    return np.union1d(np.arange(0, samples, every), [samples - 1])


def numbers(values: Array) -> list[float | None]:
    """Returns numbers with five digits; None where one is not finite."""
    return [float(f"{value:.5g}") if np.isfinite(value) else None for value in values.tolist()]


def line(
    x: Array,
    y: Array,
    name: str,
    color: str,
    *,
    dash: str = "solid",
    width: float = 1.6,
    opacity: float = 1.0,
    row: int = 0,
    group: str | None = None,
    legend: bool = True,
) -> Figure:
    """Returns a line.

    Args:
        x: Horizontal places.
        y: Vertical places.
        name: Name in the legend.
        color: Color, as CSS writes it.
        dash: Kind of line: solid, dash, dot.
        width: Width [pixels].
        opacity: Opacity, from 0 to 1.
        row: Row of axes.
        group: Name of the lines that the legend shows and hides together.
        legend: Whether the legend has it.
    """
    found: Figure = {
        "type": "scatter",
        "mode": "lines",
        "x": numbers(x),
        "y": numbers(y),
        "name": label(name),
        "line": {"color": color, "dash": dash, "width": width},
        "opacity": opacity,
        "showlegend": legend,
        **_axes(row),
    }
    return found if group is None else {**found, "legendgroup": label(group)}


def points(x: Array, y: Array, name: str, color: str, *, group: str) -> Figure:
    """Returns points; see `line`."""
    return {
        "type": "scatter",
        "mode": "markers",
        "x": numbers(x),
        "y": numbers(y),
        "name": label(name),
        "marker": {"color": color, "size": 4, "opacity": 0.45},
        "legendgroup": label(group),
    }


def band(
    x: Array, low: Array, high: Array, name: str, color: str, *, group: str, legend: bool = False
) -> Figure:
    """Returns the area between two lines; see `line`."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": numbers(np.concatenate([x, x[::-1]])),
        "y": numbers(np.concatenate([low, high[::-1]])),
        "fill": "toself",
        "fillcolor": color + "38",  # with an opacity of 22 %
        "line": {"width": 0},
        "hoverinfo": "skip",
        "name": label(name),
        "legendgroup": label(group),
        "showlegend": legend,
    }


def intervals(names: Sequence[str], value: Array, low: Array, high: Array, color: str) -> Figure:
    """Returns points with horizontal intervals, a row for each name."""
    return {
        "type": "scatter",
        "mode": "markers",
        "x": numbers(value),
        "y": [label(name) for name in names],
        "error_x": {
            "type": "data",
            "symmetric": False,
            "array": numbers(high - value),
            "arrayminus": numbers(value - low),
            "color": color,
        },
        "marker": {"color": color, "size": 9},
        "showlegend": False,
    }


def plain(x_title: str, y_title: str, height: int = 420) -> Figure:
    """Returns the layout of one pair of axes."""
    return {
        "height": height,
        "xaxis": {"title": {"text": label(x_title)}},
        "yaxis": {"title": {"text": label(y_title)}},
    }


def stacked(y_titles: Sequence[str], x_title: str) -> Figure:
    """Returns the layout of rows of axes with a common horizontal one, the first row on top."""
    rows, gap = len(y_titles), 0.04
    share = (1 - gap * (rows - 1)) / rows
    layout: Figure = {"height": ROW * rows}
    for i, title in enumerate(y_titles):
        top = 1 - i * (share + gap)
        name = _axis("yaxis", i)
        layout[name] = {"title": {"text": label(title)}, "domain": [max(top - share, 0), top]}
    layout["xaxis"] = {"title": {"text": label(x_title)}, "anchor": _axis("y", rows - 1)}
    return layout


def _axes(row: int) -> Figure:
    return {"xaxis": "x", "yaxis": _axis("y", row)}


def _axis(name: str, row: int) -> str:
    return name if row == 0 else f"{name}{row + 1}"
