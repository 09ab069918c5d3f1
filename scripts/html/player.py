"""The arm and its loops as pictures that one slider moves together.

The pictures are complete without scripts: they show the first moment. `report.js` moves the rest.
"""

from collections.abc import Callable, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array
from .blocks import Loop, Motion
from .charts import thinned

VIEWS = {"from the side": (0, 2), "from the front": (1, 2)}  # horizontal and vertical coordinates
ARM, LOOP = (280, 300), (360, 280)  # width and height of the pictures
MARGIN, LEFT, BOTTOM = 14, 44, 38  # place around a picture, and for numbers and titles of axes
POINTS = 600  # greatest number of points of a loop
SMALLEST_ANGLE, SMALLEST_TORQUE = 0.1, 0.5  # [rad], [N·m], ranges of axes
HEAD = 0.11  # [m], radius
Project = Callable[[Array], Array]


def player_parts(motions: Sequence[Motion]) -> tuple[str, dict[str, Any]]:
    """Returns the pictures of the first motion as HTML, and the data of all motions for scripts."""
    views = [_view(motions, columns) for columns in VIEWS.values()]
    axes = [_Axes(loops) for loops in zip(*(one.loops for one in motions), strict=True)]
    data = [_data(one, views, axes) for one in motions]
    pictures = [_arm_picture(name, i, data[0]) for i, name in enumerate(VIEWS)]
    pictures += [one.picture(data[0]["loops"][i]) for i, one in enumerate(axes)]
    return "".join(pictures), {"motions": data}


def _data(motion: Motion, views: Sequence[Project], axes: Sequence["_Axes"]) -> dict[str, Any]:
    return {
        "time": [round(one, 3) for one in motion.time[motion.frames].tolist()],
        "arm": [[_text(one) for one in view(motion.places)] for view in views],
        "intended": [[_text(one) for one in view(motion.intended)] for view in views],
        "body": [_text(view(motion.body[:3])) for view in views],
        "head": [_head(view, motion.body[3]) for view in views],
        "loops": [
            one.data(loop, motion.frames) for one, loop in zip(axes, motion.loops, strict=True)
        ],
    }


def _head(view: Project, middle: Array) -> list[float]:
    """Returns middle and radius of the head in a picture."""
    (x, y), (_, top) = view(np.stack([middle, middle + np.array([0, 0, HEAD])])).round(1).tolist()
    return [x, y, round(y - top, 1)]


def _view(motions: Sequence[Motion], columns: tuple[int, int]) -> Project:
    """Returns the function from places in the world to a picture that has all of every motion."""
    shown = [
        part.reshape(-1, 3)[:, columns]
        for one in motions
        for part in (one.places, one.intended, one.body, one.body[3:] + HEAD, one.body[3:] - HEAD)
    ]
    low, high = np.min(np.vstack(shown), axis=0), np.max(np.vstack(shown), axis=0)
    size = np.array(ARM) - 2 * MARGIN
    scale = float(np.min(size / np.maximum(high - low, 0.1)))
    begin = (low + high) / 2 - size / scale / 2

    def project(places: Array) -> Array:
        found = MARGIN + (places[..., columns] - begin) * scale
        found[..., 1] = ARM[1] - found[..., 1]
        return found

    return project


def _arm_picture(name: str, i: int, motion: dict[str, Any]) -> str:
    x, y, radius = motion["head"][i]
    return (
        f'<figure class="view"><svg viewBox="0 0 {ARM[0]} {ARM[1]}" role="img" '
        f'aria-label="The arm {name}; the intended arm is dashed.">'
        f'<g class="body"><polyline class="trunk" points="{motion["body"][i]}"/>'
        f'<circle class="head" cx="{x}" cy="{y}" r="{radius}"/></g>'
        f'<polyline class="intended" points="{motion["intended"][i][0]}"/>'
        f'<polyline class="arm" points="{motion["arm"][i][0]}"/>'
        f"</svg><figcaption>{name}; dashed: as intended</figcaption></figure>"
    )


class _Axes:
    """Axes that hold the loops of a joint in all motions.

    Args:
        loops: The loops.
    """

    def __init__(self, loops: Sequence[Loop]) -> None:
        self._joint, self._names = loops[0].joint.replace("_", " "), list(loops[0].torques)
        torques = [torque for loop in loops for torque in loop.torques.values()]
        self._x = _ticks(np.concatenate([loop.angle for loop in loops]), SMALLEST_ANGLE)
        self._y = _ticks(np.concatenate(torques), SMALLEST_TORQUE)

    def data(self, loop: Loop, frames: NDArray[np.intp]) -> dict[str, Any]:
        """Returns the lines of a loop, and where its markers are in each picture."""
        drawn = thinned(len(loop.angle), POINTS)
        lines = [self._project(loop.angle, torque) for torque in loop.torques.values()]
        return {
            "lines": [_text(one[drawn]) for one in lines],
            "marks": [one[frames].round(1).tolist() for one in lines],
        }

    def picture(self, loop: dict[str, Any]) -> str:
        """Returns axes, lines and markers as HTML."""
        width, height = LOOP
        right, bottom = width - MARGIN, height - BOTTOM
        parts = []
        for value in self._x:
            x = self._project(np.array([value]), self._y[:1])[0, 0]
            parts.append(_grid(x, MARGIN, x, bottom))
            parts.append(f'<text x="{x:.1f}" y="{bottom + 15}" class="middle">{value:g}</text>')
        for value in self._y:
            y = self._project(self._x[:1], np.array([value]))[0, 1]
            parts.append(_grid(LEFT, y, right, y))
            parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" class="end">{value:g}</text>')
        middle = (LEFT + right) / 2
        parts.append(f'<text x="{middle}" y="{height - 6}" class="middle">angle [rad]</text>')
        for i, (points, marks) in enumerate(zip(loop["lines"], loop["marks"], strict=True)):
            x, y = marks[0]
            parts.append(f'<polyline class="loop c{i}" points="{points}"/>')
            parts.append(f'<circle class="mark c{i}" cx="{x}" cy="{y}" r="5"/>')
        names = "".join(
            f'<span class="key"><span class="swatch c{i}"></span>{escape(name)}</span>'
            for i, name in enumerate(self._names)
        )
        what = f"{' and '.join(self._names)} over the angle of the {self._joint}"
        return (
            f'<figure class="loops"><figcaption>{escape(self._joint)} [N·m] {names}</figcaption>'
            f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="{escape(what)}.">'
            f"{''.join(parts)}</svg></figure>"
        )

    def _project(self, angle: Array, torque: Array) -> Array:
        x, y = (
            (values - ticks[0]) / (ticks[-1] - ticks[0])
            for values, ticks in ((angle, self._x), (torque, self._y))
        )
        width, height = LOOP[0] - LEFT - MARGIN, LOOP[1] - BOTTOM - MARGIN
        return np.stack([LEFT + x * width, MARGIN + (1 - y) * height], axis=-1)


def _ticks(values: Array, smallest: float) -> Array:
    """Returns round numbers at equal distances around all values, and over that range at least."""
    from matplotlib.ticker import MaxNLocator  # matplotlib is slow to import

    low, high = float(np.min(values)), float(np.max(values))
    more = max(smallest - (high - low), 0.0) / 2
    low, high = low - more, high + more
    return np.asarray(MaxNLocator(5).tick_values(low, high))


def _grid(x1: float, y1: float, x2: float, y2: float) -> str:
    return f'<line class="grid" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'


def _text(points: Array) -> str:
    """Returns points as SVG writes them."""
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())
