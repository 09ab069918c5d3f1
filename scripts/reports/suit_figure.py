"""The figure of a suit: first-order loops of every joint."""

from collections.abc import Mapping

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from ...arrays import Array
from ...assets import Suit, SuitJoint
from ...hysteresis import HysteresisModel, PoleError

TURNS = 5  # loops per joint, at equal distances
SAMPLES = 150  # number of samples per branch
COLUMNS = 2
COLORS = "viridis"


def first_order_loops(entry: SuitJoint, model: HysteresisModel) -> Mapping[str, Array]:
    """Computes loops from the lower end of a joint's range to turns and back.

    Args:
        entry: Joint of a suit, with its range and the angle at which its memory begins.
        model: Model of the joint, or one of its samples.

    Returns:
        The loops by the angle of their turn: angle [rad] and resistance [N·m], shape (2, n). Loops
        in which the torque becomes infinite are left out.
    """
    low, high = entry.range
    approach = np.linspace(entry.start_angle, low, SAMPLES)
    loops = {}
    for turn in np.linspace(low, high, TURNS + 1)[1:]:
        there = np.linspace(low, turn, SAMPLES)[1:]
        angle = np.concatenate([approach, there, there[-2::-1], [low]])
        try:
            torque = entry.response(angle, model)
        except PoleError:
            continue
        loops[f"{turn:.2f}"] = np.stack([angle, torque])[:, SAMPLES - 1 :]
    return loops


def suit_figure(suit: Suit) -> Figure:
    """Draws first-order loops of every joint of a suit over its range.

    Loops of the samples, which the data also allow, are gray.
    """
    rows = -(-len(suit.joints) // COLUMNS)
    figure = Figure(figsize=(10, 3.6 * rows), layout="constrained")
    grid = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for ax, (joint, entry) in zip(grid, suit.joints.items(), strict=False):
        _draw(ax, entry)
        ax.set_title(joint.replace("_", " "), loc="left")
        ax.set(xlabel="angle [rad]", ylabel="resistance [N·m]")
    for ax in grid[len(suit.joints) :]:
        ax.set_visible(False)
    pressure = "" if suit.pressure_kpa is None else f", {suit.pressure_kpa:g} kPa"
    label = "" if suit.label is None else f" ({suit.label})"
    figure.suptitle(f"{suit.name}{pressure}{label}", fontweight="bold")
    return figure


def _draw(ax, entry: SuitJoint) -> None:
    for sample in entry.samples:
        for angle, torque in first_order_loops(entry, sample).values():
            ax.plot(angle, torque, color="0.8", lw=0.7, zorder=1)
    loops = first_order_loops(entry, entry.model)
    colors = colormaps[COLORS].resampled(TURNS + 1)
    for i, (angle, torque) in reversed(list(enumerate(loops.values()))):
        ax.plot(angle, torque, color=colors(i), lw=1.4, zorder=2)
    if len(loops) < TURNS:
        ax.text(0.02, 0.95, "other loops meet infinite torque", transform=ax.transAxes, va="top")
    ax.axhline(0, color="0.6", lw=0.6)
    ax.grid(alpha=0.25)
