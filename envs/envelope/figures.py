"""Pictures of work envelopes: sections, and the envelope over the rendered arm."""

from collections.abc import Sequence

import mujoco
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from ...arrays import Array
from ..model import arm_spec
from ..rendering import Renderer
from .envelope import BRANCHES, SUSTAINED, Envelope

AXES = ("forward", "left", "up")
PLANES = (  # axis across the section, its position from the shoulder [m], axes to the right and up
    ("sagittal, 0.15 m outward", 1, 0.15, 0, 2),
    ("horizontal, 0.2 m below", 2, -0.2, 1, 0),
    ("frontal, 0.3 m in front", 0, 0.3, 1, 2),
)
COLORS: dict[str, str] = {
    "unsuited": "#8a94a6",
    "suited": "#0072b2",
    "assisted": "#d55e00",
    "unlimited": "#009e73",
}
FILLED: dict[str, float] = {"suited": 0.45, "assisted": 0.2}  # opacity
STYLES: dict[str, str] = {"unsuited": ":", "unlimited": "--"}
CAMERA = "overview"
FIELD_OF_VIEW = 52.0  # degrees
INNER, OUTER = 0.55, 0.25  # opacity
SMOOTHED = 12  # passes over the corners of a drawn surface


def sections_figure(envelopes: Sequence[Envelope]) -> Figure:
    """Draws the hand positions that can be kept in three planes, a row for each branch.

    Gray is what the hand reaches in any of the envelopes of the row at any effort.

    Args:
        envelopes: Envelopes of one arm; that without a suit is drawn in every row.
    """
    branches = [one for one in BRANCHES if any(e.branch == one for e in envelopes)]
    figure = Figure(figsize=(12.5, 0.7 + 4.1 * len(branches)), layout="constrained")
    grid = figure.subplots(len(branches), len(PLANES), squeeze=False)
    for axes, branch in zip(grid, branches, strict=True):
        row = [one for one in envelopes if one.branch == branch or one.condition == "unsuited"]
        for ax, (title, across, place, right, up) in zip(axes, PLANES, strict=True):
            for one in row:
                _draw_section(ax, one, across, place, right, up)
            ax.plot(0, 0, "+", color="k", ms=9)
            ax.set(title=title, xlabel=f"{AXES[right]} [m]", ylabel=f"{AXES[up]} [m]")
            ax.set_aspect("equal")
            if right == 1:
                ax.invert_xaxis()  # the wearer sees it so
        axes[0].annotate(
            *(branch, (-0.28, 0.5)),
            xycoords="axes fraction",
            rotation=90,
            va="center",
            fontweight="bold",
        )
    drawn = [one for one in COLORS if any(e.condition == one for e in envelopes)]
    lines = [Line2D([], [], color=COLORS[c], ls=STYLES.get(c, "-"), lw=1.8) for c in drawn]
    figure.legend(lines, drawn, loc="outside lower center", ncols=len(drawn), frameon=False)
    return figure


def _draw_section(
    ax: Axes, envelope: Envelope, across: int, place: float, right: int, up: int
) -> None:
    if across == 1 and envelope.config.side == "right":
        place = -place
    inside = envelope.cells[:, across] == int(np.floor(place / envelope.spacing))
    if not inside.any():
        return
    columns, rows = envelope.cells[inside][:, [right, up]].T
    half = 2 + int(max(np.abs(columns).max(), np.abs(rows).max()))
    line = (np.arange(-half, half) + 0.5) * envelope.spacing
    # 1 where the hand can be; and 1/2 where holding it there takes the share that counts.
    reached, kept = np.zeros((2, 2 * half, 2 * half))
    reached[rows + half, columns + half] = 1
    kept[rows + half, columns + half] = np.clip(1 - envelope.effort[inside] / (2 * SUSTAINED), 0, 1)
    ax.contourf(line, line, reached, levels=[0.5, 2], colors=["0.5"], alpha=0.12)
    if kept.max() < 0.5:
        return
    color, style = COLORS[envelope.condition], STYLES.get(envelope.condition, "-")
    opacity = FILLED.get(envelope.condition, 0)
    ax.contourf(line, line, kept, levels=[0.5, 2], colors=[color], alpha=opacity)
    ax.contour(line, line, kept, levels=[0.5], colors=[color], linestyles=[style], linewidths=1.6)


def envelope_picture(
    envelopes: Sequence[Envelope], *, width: int = 900, height: int = 900
) -> NDArray[np.uint8]:
    """Renders the arm with the hand positions that can be kept, shape (height, width, 3).

    Args:
        envelopes: Envelopes of one arm, inner ones first; those that hold nothing are left out.
        width: Width of the picture [pixels].
        height: Height of the picture [pixels].

    Raises:
        RenderingUnavailableError: This machine has no OpenGL.
    """
    spec = arm_spec(envelopes[0].config)
    torso, shoulder = spec.body("torso"), spec.body("shoulder")
    for envelope in envelopes:
        kept = envelope.cells[envelope.effort <= SUSTAINED]
        if not kept.size:
            continue
        mesh = f"envelope_{envelope.condition}"
        vertices, faces = _surface(kept)
        spec.add_mesh(
            name=mesh,
            uservert=(vertices * envelope.spacing).ravel(),
            userface=faces.ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        red, green, blue = to_rgb(COLORS[envelope.condition])
        opacity = INNER if envelope is not envelopes[-1] else OUTER
        spec.add_material(name=mesh, emission=0.5, rgba=[red, green, blue, opacity])
        torso.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=mesh,
            material=mesh,
            pos=shoulder.pos,
            group=2,
            contype=0,
            conaffinity=0,
            mass=0,
        )
    for light in spec.lights:
        light.castshadow = False  # what is only drawn in the air has none
    spec.camera(CAMERA).fovy = FIELD_OF_VIEW
    model = spec.compile()
    model.vis.global_.offwidth, model.vis.global_.offheight = width, height
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("reach").id)
    mujoco.mj_forward(model, data)
    renderer = Renderer(camera=CAMERA, width=width, height=height, quality="fine")
    try:
        return renderer.picture(model, data)
    finally:
        renderer.close()


def _surface(cells: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Returns a smoothed surface around cells: corners in cells, and triangles of corners."""
    low = cells.min(axis=0) - 1
    full = np.zeros(cells.max(axis=0) - low + 2, dtype=bool)
    full[tuple((cells - low).T)] = True
    quads = []
    for axis in range(3):
        for way in (1, -1):
            bare = full & ~np.roll(full, -way, axis=axis)
            corner = np.argwhere(bare) + (np.arange(3) == axis) * (way == 1)
            one, other = np.eye(3, dtype=np.int64)[[(axis + 1) % 3, (axis + 2) % 3]]
            around = np.stack([corner, corner + one, corner + one + other, corner + other], axis=1)
            quads.append(around[:, ::way])
    corners, numbers = np.unique(np.concatenate(quads).reshape(-1, 3), axis=0, return_inverse=True)
    quad = numbers.reshape(-1, 4)
    place = corners + low.astype(np.float64)
    begin, end = quad.ravel(), np.roll(quad, -1, axis=1).ravel()
    neighbors = np.bincount(begin, minlength=len(place))[:, None]
    for _ in range(SMOOTHED):
        total = np.zeros_like(place)
        np.add.at(total, begin, place[end])
        place = (place + total / neighbors) / 2
    return place, np.concatenate([quad[:, :3], quad[:, [0, 2, 3]]])
