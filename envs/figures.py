"""Figures of simulated motions. A figure function takes data and returns the figure."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..arrays import Array
from ..assets import JOINTS
from .evaluation import Trace
from .model import ASSISTED
from .model.cuffs import FORCE_LIMITS

ASSISTED_COLUMNS = [JOINTS.index(joint) for joint in ASSISTED]
COLORS = {
    "unsuited": "#bbbbbb",
    "suited": "#555555",
    "none": "#000000",
    "transparent": "#e69f00",
    "gravity": "#cc79a7",
    "feedforward": "#0072b2",
    "compensation": "#d55e00",
    "complement": "#56b4e9",
    "oracle": "#009e73",
    "best-known-plan": "#009e73",
}
OTHERS = ("#8c564b", "#9467bd", "#17becf")
HEAT = "motor load\n[% of continuous]"
STYLES = {"oracle": "--", "gravity": "-.", "best-known-plan": "--", "unsuited": ":", "suited": ":"}


def trajectory_figure(traces: Mapping[str, Trace]) -> Figure:
    """Draws intended and actual angles of the assisted joints over time, one line per policy."""
    figure = Figure(figsize=(10, 5), layout="constrained")
    axes = figure.subplots(len(ASSISTED), 1, sharex=True)
    first = next(iter(traces.values()))
    for ax, joint, column in zip(axes, ASSISTED, ASSISTED_COLUMNS, strict=True):
        ax.plot(first.time, first.target_angle[:, column], color="0.8", lw=4, label="intended")
        for policy, color in _colors(traces).items():
            angle = traces[policy].angle[:, column]
            ax.plot(
                traces[policy].time, angle, color=color, lw=1.2, ls=_style(policy), label=policy
            )
        ax.set_ylabel(f"{joint.replace('_', ' ')} [rad]")
        ax.grid(alpha=0.25)
    axes[0].legend(ncols=len(traces) + 1, frameon=False, loc="lower left", bbox_to_anchor=(0, 1))
    axes[-1].set_xlabel("time [s]")
    return figure


def torques_figure(traces: Mapping[str, Trace]) -> Figure:
    """Draws human, suit and assist torque of the assisted joints over time, one line per policy."""
    figure = Figure(figsize=(11, 7), layout="constrained")
    rows = ("human torque", "suit torque", "assist torque")
    grid = figure.subplots(len(rows), len(ASSISTED), sharex=True)
    for policy, color in _colors(traces).items():
        trace = traces[policy]
        series = (
            trace.human_torque[:, ASSISTED_COLUMNS],
            trace.suit_torque[:, ASSISTED_COLUMNS],
            trace.assist_torque,
        )
        for axes, values in zip(grid, series, strict=True):
            for ax, torque in zip(axes, values.T, strict=True):
                ax.plot(trace.time, torque, color=color, lw=1.2, ls=_style(policy), label=policy)
    for axes, row in zip(grid, rows, strict=True):
        axes[0].set_ylabel(f"{row} [N·m]")
        for ax in axes:
            ax.axhline(0, color="0.6", lw=0.6)
            ax.grid(alpha=0.25)
    return _over_time(figure, grid, len(traces))


def _over_time(figure: Figure, grid: Any, policies: int) -> Figure:
    """Names the joints above, the time below, and the policies in one row; returns the figure."""
    for ax, joint in zip(grid[0], ASSISTED, strict=True):
        ax.set_title(joint.replace("_", " "), loc="left")
    for ax in grid[-1]:
        ax.set_xlabel("time [s]")
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=policies, frameon=False)
    return figure


def motion_loops_figure(traces: Mapping[str, Trace]) -> Figure:
    """Draws suit resistance and human torque over the joint angle, one line per policy."""
    figure = Figure(figsize=(10, 7.6), layout="constrained")
    grid = figure.subplots(2, len(ASSISTED), sharex="col")
    for policy, color in _colors(traces).items():
        trace = traces[policy]
        style = _style(policy)
        for axes, values in zip(grid, (-trace.suit_torque, trace.human_torque), strict=True):
            for ax, column in zip(axes, ASSISTED_COLUMNS, strict=True):
                angle, torque = trace.angle[:, column], values[:, column]
                ax.plot(angle, torque, color=color, lw=1.0, ls=style, label=policy)
    for ax, joint in zip(grid[0], ASSISTED, strict=True):
        ax.set_title(joint.replace("_", " "), loc="left")
    for ax in grid[-1]:
        ax.set_xlabel("angle [rad]")
    for ax in grid.flat:
        ax.axhline(0, color="0.6", lw=0.6)
        ax.grid(alpha=0.25)
    grid[0][0].set_ylabel("suit resistance, minus suit torque [N·m]")
    grid[1][0].set_ylabel("human torque [N·m]")
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(traces), frameon=False)
    return figure


def strain_figure(traces: Mapping[str, Trace]) -> Figure:
    """Draws what the wearer and the motors bear at the assisted joints, one line per policy.

    That is effort over time, the strength of the weaker muscles, the fatigued part of the more
    fatigued ones where muscles tire, and the motors' heat where there are motors.
    """
    drawn: dict[str, dict[str, Array | None]] = {
        "effort [% of strength]": {
            name: 100 * one.effort[:, ASSISTED_COLUMNS] for name, one in traces.items()
        },
        "strength [N·m]": {
            name: one.strength.min(axis=1)[:, ASSISTED_COLUMNS] for name, one in traces.items()
        },
        "fatigued [%]": {
            name: None
            if one.fatigue is None
            else 100 * one.fatigue.max(axis=1)[:, ASSISTED_COLUMNS]
            for name, one in traces.items()
        },
        HEAT: {
            name: None if one.motor_load is None else 100 * one.motor_load
            for name, one in traces.items()
        },
    }
    rows = {
        label: series
        for label, series in drawn.items()
        if any(one is not None for one in series.values())
    }
    figure = Figure(figsize=(11, 2.3 * len(rows) + 0.6), layout="constrained")
    grid = figure.subplots(len(rows), len(ASSISTED), sharex=True)
    colors = _colors(traces)
    for axes, (label, series) in zip(grid, rows.items(), strict=True):
        axes[0].set_ylabel(label)
        for i, ax in enumerate(axes):
            for name, values in series.items():
                if values is not None:
                    style = {"color": colors[name], "lw": 1.2, "ls": _style(name)}
                    ax.plot(traces[name].time, values[:, i], label=name, **style)
            if label == HEAT:
                ax.axhline(100, color="0.3", lw=0.8, ls=":")  # a motor is hot
            ax.set_ylim(0, 1.05 * ax.get_ylim()[1])
            ax.grid(alpha=0.25)
    return _over_time(figure, grid, len(traces))


def cuff_forces_figure(traces: Mapping[str, Trace]) -> Figure:
    """Draws the forces of the cuffs over time, and the largest ones that a person should bear.

    Args:
        traces: Motions with cuffs, by the name of the policy.
    """
    figure = Figure(figsize=(10, 6.5), layout="constrained")
    axes = figure.subplots(len(FORCE_LIMITS), 1, sharex=True)
    for policy, color in _colors(traces).items():
        trace = traces[policy]
        assert trace.cuff_force is not None
        sizes = np.linalg.norm(trace.cuff_force, axis=-1).T
        for ax, force in zip(axes, sizes, strict=True):
            ax.plot(trace.time, force, color=color, lw=1.2, ls=_style(policy), label=policy)
    for ax, (segment, limit) in zip(axes, FORCE_LIMITS.items(), strict=True):
        ax.axhline(limit, color="#d62728", lw=1.2, label="ISO/TS 15066")
        ax.set_ylim(bottom=0)
        ax.set_ylabel(f"{segment.replace('_', ' ')} [N]")
        ax.grid(alpha=0.25)
    axes[0].legend(ncols=len(traces) + 1, frameon=False, loc="lower left", bbox_to_anchor=(0, 1))
    axes[-1].set_xlabel("time [s]")
    return figure


def _colors(traces: Mapping[str, Trace]) -> dict[str, str]:
    others = iter(OTHERS * len(traces))
    return {policy: COLORS.get(policy) or next(others) for policy in traces}


def _style(policy: str) -> str:
    return STYLES.get(policy, "-")
