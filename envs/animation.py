"""Draws the torque-angle loops of a motion, as a moving panel beside the arm."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..arrays import Array
from ..assets import JOINTS
from .evaluation.figures import ASSISTED_COLUMNS

INCHES = 5.4  # [in], height of the figure, so that letters grow with the picture
TAIL = 0.22  # share of the motion, before the present, that is bright
BACKGROUND, INK, GRID = "#1f252e", "#e3e8ee", "#39424e"
SUIT, WEARER = "#62b4f5", "#ff8b3d"


class LoopPanel:
    """Torque over angle of shoulder and elbow flexion along a motion, in a picture [pixels].

    The whole loops are faint, and the part just before the present is bright. Joint angles [rad],
    the resistance of the suit (minus its torque on the joints) and the wearer's torque [N·m] are
    evenly sampled, shape (n, 4), with columns as `JOINTS`.
    """

    def __init__(
        self, angle: Array, resistance: Array, human_torque: Array, *, width: int, height: int
    ) -> None:
        dpi = height / INCHES
        figure = Figure(figsize=(width / dpi, INCHES), dpi=dpi, facecolor=BACKGROUND)
        figure.subplots_adjust(left=0.16, right=0.94, bottom=0.11, top=0.83, hspace=0.42)
        self._canvas = FigureCanvasAgg(figure)
        self._curves = []
        for x, name, color in ((0.16, "suit resists", SUIT), (0.55, "wearer exerts", WEARER)):
            figure.text(x, 0.93, name, color=color, size=14, weight="bold")
        axes = figure.subplots(len(ASSISTED_COLUMNS), 1)
        for ax, column in zip(axes, ASSISTED_COLUMNS, strict=True):
            _dress(ax, JOINTS[column].replace("_", " "))
            for torque, color in ((resistance, SUIT), (human_torque, WEARER)):
                points = np.column_stack([angle[:, column], torque[:, column]])
                self._curves.append(_Curve(ax, points, color))
        axes[-1].set_xlabel("angle [rad]", color=INK, size=11)

    def picture(self, sample: int) -> NDArray[np.uint8]:
        """Returns the panel (height, width, 3) at number `sample` of the series."""
        for curve in self._curves:
            curve.move_to(sample)
        self._canvas.draw()
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


class _Curve:
    """A curve with a bright tail, and a dot at the present."""

    def __init__(self, ax: Axes, points: Array, color: str) -> None:
        self._points = points
        self._tail = np.arange(-round(TAIL * len(points)), 1)
        colors = np.tile(to_rgba(color), (len(self._tail) - 1, 1))
        colors[:, 3] = np.linspace(0, 1, len(colors)) ** 1.5
        self._line = LineCollection([], colors=colors, linewidths=3.2)
        ax.add_collection(self._line)
        (self._dot,) = ax.plot([], [], "o", color=color, ms=8, mec=BACKGROUND, mew=1.2, zorder=3)
        ax.plot(*points.T, color=color, alpha=0.45, lw=1.3)

    def move_to(self, sample: int) -> None:
        """Moves the end of the tail to `sample`."""
        points = self._points[(sample + self._tail).clip(0)]
        self._line.set_segments([*np.stack([points[:-1], points[1:]], axis=1)])
        self._dot.set_data(*points[-1:].T)


def _dress(ax: Axes, title: str) -> None:
    ax.set_facecolor(BACKGROUND)
    ax.set_title(title, loc="left", color=INK, size=12)
    ax.set_ylabel("torque [N·m]", color=INK, size=11)
    ax.tick_params(colors=INK, labelsize=10, length=0)
    ax.grid(color=GRID, lw=0.8)
    ax.axhline(0, color=INK, lw=0.8, alpha=0.5)
    ax.spines[:].set_visible(False)
