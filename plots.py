"""Figures as data: a figure is described once, and drawn by matplotlib or by plotly.

    from activesuit.plots import Line, Panel, Plot

    angle = np.linspace(0, 1)
    plot = Plot(panels=[Panel(x="angle [rad]", y="torque [N·m]", marks=[Line(angle, angle**2)])])
    plot.figure().savefig("torque.png")  # matplotlib

A file has all panels in rows and columns; a page of HTML has a figure of plotly for each.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Colors that differ on white and on nearly black, also for most people who see few colors.
PALETTE = (
    *("#2f86d0", "#d55e00", "#0f9d73", "#b565a7", "#d08700", "#3aa6c9", "#a0674b", "#7a6ad8"),
)
GRAY = "#8a8f98"
# The references and the bound look the same in every figure; other names get the next color.
FIXED = {
    **{name: (GRAY, "dot") for name in ("unsuited", "samples", "measured")},
    "suited": (GRAY, "dash"),
    "intended": ("#b9bdc4", "solid"),
    "best-known-plan": ("#8a8d1f", "dash"),  # a color that PALETTE lacks
}
DASHES = {"solid": "-", "dash": "--", "dot": ":"}
GOOD_TO_BAD = [[0, "#1a9850"], [0.5, "#fee08b"], [1, "#d73027"]]
LARGEST = 1e12  # largest number that is drawn; matplotlib fails at some larger numbers
LEAST_HEIGHT = 0.1  # of an angle axis [rad], so that noise does not fill the axis
DRAWN = 400, 2700  # greatest numbers of points on a page: of a line, and about of a panel


@dataclass(frozen=True)
class Line:
    """A line, or points.

    Attributes:
        x: Horizontal places, shape (samples,).
        y: Vertical places, shape (samples,).
        name: Name in the legend; marks of the same name have the same color. "" means no entry.
        points: Whether to draw points in place of a line.
        width: Width of the line [points].
        color: Color of CSS; by default the color of the name.
        dash: "solid", "dash" or "dot"; by default the dash of the name.
    """

    x: ArrayLike
    y: ArrayLike
    name: str = ""
    points: bool = False
    width: float = 1.3
    color: str | None = None
    dash: str | None = None


@dataclass(frozen=True)
class Band:
    """The area between two lines; see `Line`."""

    x: ArrayLike
    low: ArrayLike
    high: ArrayLike
    name: str = ""
    color: str | None = None


@dataclass(frozen=True)
class Intervals:
    """Values with intervals, a row for each label."""

    labels: Sequence[str]
    value: ArrayLike
    low: ArrayLike
    high: ArrayLike
    name: str = ""
    color: str | None = None


@dataclass(frozen=True)
class Cells:
    """A table of numbers in colors.

    Attributes:
        values: Numbers from 0 (good) to 1 (bad), which the colors show, shape (rows, columns).
        texts: Texts of the cells, in the same order.
        rows: Names of the rows, from above.
        columns: Names of the columns.
    """

    values: ArrayLike
    texts: Sequence[Sequence[str]]
    rows: Sequence[str]
    columns: Sequence[str]
    name: str = ""
    color: str | None = None


Mark = Line | Band | Intervals | Cells


@dataclass(frozen=True, kw_only=True)
class Panel:
    """Axes with marks.

    Attributes:
        x: Title of the horizontal axis, with the unit.
        y: Title of the vertical axis, with the unit.
        marks: What is drawn, from the back to the front.
        title: Title above the panel.
        levels: Heights of dotted horizontal lines, by their meaning.
        logarithmic: Whether the vertical axis is logarithmic.
        least: Least length of the vertical axis.
        from_zero: Whether the vertical axis begins at 0.
    """

    x: str
    y: str
    marks: Sequence[Mark]
    title: str = ""
    levels: Mapping[str, float] = field(default_factory=dict)
    logarithmic: bool = False
    least: float = 0.0
    from_zero: bool = False


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A figure.

    Attributes:
        panels: Panels, row by row.
        title: What the figure shows.
        columns: Number of panels in a row of a file.
        height: Height of a row in a file [inch].
    """

    panels: Sequence[Panel]
    title: str = ""
    columns: int = 1
    height: float = 3.4

    def styles(self) -> dict[str, tuple[str, str]]:
        """Returns color and dash of each name, in the order of the legend."""
        named = {mark.name: mark for panel in self.panels for mark in panel.marks if mark.name}
        colors = iter(PALETTE * (1 + len(named)))
        found = {}
        for name, mark in named.items():
            color, dash = FIXED.get(name) or (mark.color or next(colors), "solid")
            found[name] = mark.color or color, getattr(mark, "dash", None) or dash
        return found

    def figure(self) -> "Figure":
        """Returns the figure of matplotlib."""
        from matplotlib.figure import Figure

        rows = -(-len(self.panels) // self.columns)
        size = (5.4 * self.columns if self.columns > 1 else 8.0, self.height * rows + 0.4)
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(rows, self.columns, squeeze=False).flat
        styles, handles = self.styles(), {}
        for ax, panel in zip(grid, self.panels, strict=False):
            _draw(ax, panel, styles)
            for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
                handles.setdefault(label, handle)
        for ax in list(grid)[len(self.panels) :]:
            ax.remove()
        if handles:
            figure.legend(
                *(handles.values(), handles.keys()),
                loc="outside upper center",
                ncols=max(1, min(len(handles), 3 * self.columns)),
                frameon=False,
                markerscale=2,
            )
        return figure

    def plotly(self) -> list[dict[str, Any]]:
        """Returns data and layout of each panel, as plotly takes them."""
        styles = self.styles()
        return [
            {"data": list(_traces(panel, styles)), "layout": _layout(panel)}
            for panel in self.panels
        ]


def thinned(samples: int, most: int) -> NDArray[np.intp]:
    """Returns indices of about `most` samples at equal distances, and of the last sample."""
    return np.union1d(np.arange(0, samples, max(1, -(-samples // most))), [samples - 1])


def _style(mark: Mark, styles: Mapping[str, tuple[str, str]]) -> tuple[str, str]:
    color, dash = styles.get(mark.name, (mark.color or GRAY, getattr(mark, "dash", None)))
    return mark.color or color, getattr(mark, "dash", None) or dash or "solid"


def _draw(ax: "Axes", panel: Panel, styles: Mapping[str, tuple[str, str]]) -> None:
    """Draws a panel by matplotlib."""
    for mark in panel.marks:
        color, dash = _style(mark, styles)
        label = mark.name or None
        match mark:
            case Line():
                line = {"ls": DASHES[dash], "lw": mark.width}
                style = {"marker": ".", "ls": "", "ms": 2.5} if mark.points else line
                ax.plot(*_drawn(mark.x, mark.y), color=color, label=label, **style)
            case Band():
                x, low, high = _drawn(mark.x, mark.low, mark.high)
                ax.fill_between(x, low, high, color=color, alpha=0.2, lw=0)
            case Intervals():
                value, low, high = _drawn(mark.value, mark.low, mark.high)
                ends = np.array([value - low, high - value])
                ax.errorbar(value, list(mark.labels), xerr=ends, fmt="o", color=color, label=label)
                ax.invert_yaxis()
            case Cells():
                _draw_cells(ax, mark)
    for meaning, level in panel.levels.items():
        ax.axhline(level, color="0.5", lw=0.8, ls=":")
        where = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
        ax.annotate(
            meaning, (1, level), xytext=(-2, 2), ha="right", fontsize=8, color="0.35", **where
        )
    ax.set(xlabel=panel.x, ylabel=panel.y, yscale="log" if panel.logarithmic else "linear")
    if panel.title:
        ax.set_title(panel.title, loc="left", fontsize=10)
    if panel.from_zero:
        ax.set_ylim(0, 1.05 * ax.get_ylim()[1])
    low, high = ax.get_ylim()
    if abs(high - low) < panel.least:
        middle = (low + high) / 2
        ax.set_ylim(middle - panel.least / 2, middle + panel.least / 2)
    if not any(isinstance(mark, Cells) for mark in panel.marks):
        ax.grid(alpha=0.25)


def _drawn(*series: ArrayLike) -> list[Array]:
    """Returns series as arrays, with NaN in place of numbers that matplotlib cannot draw."""
    every = (np.asarray(one, dtype=np.float64) for one in series)
    return [np.where(np.abs(one) < LARGEST, one, np.nan) for one in every]


def _draw_cells(ax: "Axes", mark: Cells) -> None:
    values = np.asarray(mark.values)
    ax.imshow(values, vmin=0, vmax=1, cmap="RdYlGn_r", aspect="auto")
    for row, texts in enumerate(mark.texts):
        for column, text in enumerate(texts):
            color = "black" if 0.15 < values[row, column] < 0.85 else "white"
            ax.text(column, row, text, fontsize=9, color=color, ha="center", va="center")
    ax.set_xticks(range(len(mark.columns)), list(mark.columns))
    ax.set_yticks(range(len(mark.rows)), list(mark.rows))


def _traces(panel: Panel, styles: Mapping[str, tuple[str, str]]) -> Iterator[dict[str, Any]]:
    """Yields the traces of plotly of a panel."""
    most = min(DRAWN[0], DRAWN[1] // max(1, len(panel.marks)))
    for mark in panel.marks:
        color, dash = _style(mark, styles)
        common = {"name": _text(mark.name), "meta": mark.name, "showlegend": False}
        match mark:
            case Line():
                x, y = _drawn(mark.x, mark.y)
                kept = thinned(x.size, most)
                drawn = (
                    {"mode": "markers", "marker": {"color": color, "size": 3.5}}
                    if mark.points
                    else {"mode": "lines", "line": {"color": color, "dash": dash, "width": 1.7}}
                )
                yield common | drawn | {"x": _numbers(x[kept]), "y": _numbers(y[kept])}
            case Band():
                x, low, high = _drawn(mark.x, mark.low, mark.high)
                kept = thinned(x.size, most)
                yield common | {
                    "x": _numbers(np.concatenate([x[kept], x[kept][::-1]])),
                    "y": _numbers(np.concatenate([low[kept], high[kept][::-1]])),
                    **{"mode": "lines", "fill": "toself", "fillcolor": f"{color}38"},
                    **{"line": {"width": 0}, "hoverinfo": "skip"},
                }
            case Intervals():
                value, low, high = _drawn(mark.value, mark.low, mark.high)
                ends = {"array": _numbers(high - value), "arrayminus": _numbers(value - low)}
                yield common | {
                    **{"mode": "markers", "marker": {"color": color, "size": 9}},
                    **{"x": _numbers(value), "y": [*map(_text, mark.labels)]},
                    "error_x": {"type": "data", "symmetric": False, "color": color, **ends},
                }
            case Cells():
                yield common | {
                    **{"type": "heatmap", "z": np.asarray(mark.values, float).tolist()},
                    **{"zmin": 0, "zmax": 1, "colorscale": GOOD_TO_BAD},
                    **{"showscale": False, "x": [*map(_text, mark.columns)]},
                    "y": [*map(_text, mark.rows)],
                    "text": [[*map(_text, row)] for row in mark.texts],
                    **{"texttemplate": "%{text}", "hoverinfo": "skip"},
                }


def _layout(panel: Panel) -> dict[str, Any]:
    """Returns the layout of plotly of a panel."""
    y: dict[str, Any] = {"title": {"text": panel.y}}
    if panel.logarithmic:
        y["type"] = "log"
    if panel.from_zero:
        y["rangemode"] = "tozero"
    values = [np.asarray(one.y, float) for one in panel.marks if isinstance(one, Line)]
    if panel.least and values:
        low, high = (float(end(np.concatenate(values))) for end in (np.nanmin, np.nanmax))
        if high - low < panel.least:
            y["range"] = [(low + high - panel.least) / 2, (low + high + panel.least) / 2]
    rows = [len(one.labels) for one in panel.marks if isinstance(one, Intervals)]
    if rows or any(isinstance(one, Cells) for one in panel.marks):
        y |= {"autorange": "reversed", "type": "category", "automargin": True}
    shapes, notes = [], []
    for meaning, level in panel.levels.items():
        ends = {"xref": "paper", "x0": 0, "x1": 1, "y0": level, "y1": level}
        shapes.append({"type": "line", **ends, "line": {"color": GRAY, "dash": "dot", "width": 1}})
        place = {"xref": "paper", "x": 1, "xanchor": "right", "y": level, "yanchor": "bottom"}
        notes.append({"text": meaning, "showarrow": False, "font": {"size": 11}, **place})
    return {
        "title": {"text": _text(panel.title), "font": {"size": 14}, "x": 0.01},
        "xaxis": {"title": {"text": panel.x}, "automargin": True},
        "yaxis": y,
        "shapes": shapes,
        "annotations": notes,
        "height": 130 + 34 * max(rows) if rows else 340,
    }


def _text(text: str) -> str:
    """Returns a text that plotly shows unchanged: plotly reads some HTML in texts."""
    return escape(text, quote=False).replace("\n", "<br>")


def _numbers(values: Array) -> list[float | None]:
    """Returns numbers with five digits, and None in place of numbers that are not finite."""
    return [float(f"{one:.5g}") if np.isfinite(one) else None for one in values.tolist()]
