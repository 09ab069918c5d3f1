"""Evaluations as figures: the relief of each policy, and simulated motions."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...plots import LEAST_HEIGHT, PALETTE, Intervals, Line, Mark, Panel, Plot
from ..model import ASSISTED
from ..model.cuffs import FORCE_LIMITS
from .rollout import Trace
from .scores import REFERENCES

if TYPE_CHECKING:
    from .compare import Evaluation

ASSISTED_COLUMNS = [JOINTS.index(joint) for joint in ASSISTED]
TITLES = [joint.replace("_", " ") for joint in ASSISTED]
HEAT = "motor load [% of continuous]"
Traces = Mapping[str, Trace]


def motion_plots(traces: Traces, place: str = "") -> dict[str, Plot]:
    """Returns all figures of motions, by the names of their files.

    Args:
        traces: Motions by the name of the policy.
        place: What was simulated, for the titles.
    """
    plots = {
        "trajectory": trajectory_plot(traces),
        "torques": torques_plot(traces),
        "motion-loops": motion_loops_plot(traces),
        "strain": strain_plot(traces),
    }
    cuffs = {name: one for name, one in traces.items() if one.cuff_force is not None}
    if cuffs:
        plots["cuff-forces"] = cuff_forces_plot(cuffs)
    named = f": {place}" if place else ""
    return {
        name: Plot(**{**vars(plot), "title": plot.title + named}) for name, plot in plots.items()
    }


def trajectory_plot(traces: Traces) -> Plot:
    """Returns intended and actual angles of the assisted joints over time, a line per policy."""
    first = next(iter(traces.values()))
    panels = []
    for title, column in zip(TITLES, ASSISTED_COLUMNS, strict=True):
        intended = Line(first.time, first.target_angle[:, column], "intended", width=4)
        marks: list[Mark] = [intended]
        marks += [Line(one.time, one.angle[:, column], name) for name, one in traces.items()]
        panels.append(_panel("time [s]", f"{title} [rad]", marks, least=LEAST_HEIGHT))
    return Plot(title="Intended and actual angles", panels=panels, height=2.6)


def torques_plot(traces: Traces) -> Plot:
    """Returns human, suit and assist torque of the assisted joints over time."""
    rows = {
        "human torque [N·m]": _columns(traces, lambda one: one.human_torque[:, ASSISTED_COLUMNS]),
        "suit torque [N·m]": _columns(traces, lambda one: one.suit_torque[:, ASSISTED_COLUMNS]),
        "assist torque [N·m]": _columns(traces, lambda one: one.assist_torque),
    }
    return _over_time("Torques over time", traces, rows, levels={"": 0.0})


def motion_loops_plot(traces: Traces) -> Plot:
    """Returns suit resistance and human torque over the joint angle, a line per policy."""
    rows = {
        "suit resistance [N·m]": _columns(traces, lambda one: -one.suit_torque),
        "human torque [N·m]": _columns(traces, lambda one: one.human_torque),
    }
    panels = [
        _panel(
            "angle [rad]",
            label,
            [Line(traces[n].angle[:, i], torque[:, i], n, width=1) for n, torque in row.items()],
            title=title,
        )
        for label, row in rows.items()
        for title, i in zip(TITLES, ASSISTED_COLUMNS, strict=True)
    ]
    return Plot(title="Torques over angle", panels=panels, columns=len(ASSISTED))


def strain_plot(traces: Traces) -> Plot:
    """Returns what the wearer and the motors bear at the assisted joints, a line per policy.

    That is effort over time, the strength of the weaker muscles, the fatigued part of the more
    fatigued ones where muscles tire, and the motors' heat where there are motors.
    """
    columns = ASSISTED_COLUMNS
    rows = {
        "effort [% of strength]": _columns(traces, lambda one: 100 * one.effort[:, columns]),
        "strength [N·m]": _columns(traces, lambda one: one.strength.min(axis=1)[:, columns]),
        "fatigued [%]": {
            name: 100 * one.fatigue.max(axis=1)[:, columns]
            for name, one in traces.items()
            if one.fatigue is not None
        },
        HEAT: {
            name: 100 * one.motor_load for name, one in traces.items() if one.motor_load is not None
        },
    }
    shown = {label: row for label, row in rows.items() if row}
    return _over_time("Effort, fatigue and heat", traces, shown, height=2.4, from_zero=True)


def cuff_forces_plot(traces: Traces) -> Plot:
    """Returns the forces of the cuffs over time, and the largest ones that a person should bear.

    Args:
        traces: Motions with cuffs, by the name of the policy.
    """
    sizes = {
        name: np.linalg.norm(np.asarray(one.cuff_force), axis=-1) for name, one in traces.items()
    }
    panels = [
        _panel(
            "time [s]",
            f"{segment.replace('_', ' ')} [N]",
            [Line(traces[name].time, size[:, i], name) for name, size in sizes.items()],
            levels={"most that one should bear, ISO/TS 15066": limit},
            from_zero=True,
        )
        for i, (segment, limit) in enumerate(FORCE_LIMITS.items())
    ]
    return Plot(title="Forces of the cuffs", panels=panels, height=2.4)


def _columns(traces: Traces, of: Any) -> dict[str, Array]:
    return {name: of(one) for name, one in traces.items()}


def _over_time(
    title: str,
    traces: Traces,
    rows: Mapping[str, Mapping[str, Array]],
    height: float = 2.6,
    **options: Any,
) -> Plot:
    """Returns a row of panels for each quantity, a column for each assisted joint."""
    panels = [
        _panel(
            "time [s]",
            label,
            [Line(traces[name].time, values[:, i], name) for name, values in row.items()],
            title=joint,
            **options | ({"levels": {"a motor is hot": 100.0}} if label == HEAT else {}),
        )
        for label, row in rows.items()
        for i, joint in enumerate(TITLES)
    ]
    return Plot(title=title, panels=panels, columns=len(ASSISTED), height=height)


def _panel(x: str, y: str, marks: Sequence[Mark], **options: Any) -> Panel:
    return Panel(x=x, y=y, marks=marks, **options)


def relief_plot(evaluation: "Evaluation") -> Plot | None:
    """Returns the relief of each policy with its 95 % interval; None where no relief is known."""
    found = {name: evaluation.relief(name) for name in evaluation.scores if name not in REFERENCES}
    known = {name: one for name, one in found.items() if one is not None}
    if not known:
        return None
    ends = ("value", "low", "high")
    value, low, high = ([getattr(one, end) for one in known.values()] for end in ends)
    marks = [Intervals([*known], value, low, high, color=PALETTE[0])]
    axis = "relief: 0 is the suit alone, 1 is no suit"
    panel = Panel(x=axis, y="", marks=marks)
    height = 1.0 + 0.35 * len(known)
    return Plot(title="Relief, with its 95 % interval", panels=[panel], height=height)
