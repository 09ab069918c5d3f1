"""Evaluations as figures: the relief of each policy, and simulated motions."""

from collections.abc import Mapping
from dataclasses import replace
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
    """Returns all figures of motions by policy, by the names of their files; `place` for titles."""
    human = {name: one.human_torque[:, ASSISTED_COLUMNS] for name, one in traces.items()}
    suit = {name: one.suit_torque[:, ASSISTED_COLUMNS] for name, one in traces.items()}
    assist = {name: one.assist_torque for name, one in traces.items()}
    torques = {
        "human torque [N·m]": human,
        "suit torque [N·m]": suit,
        "assist torque [N·m]": assist,
    }
    plots = {
        "trajectory": trajectory_plot(traces),
        "torques": _over_time("Torques over time", traces, torques, levels={"": 0.0}),
        "motion-loops": motion_loops_plot(traces),
        "strain": strain_plot(traces),
    }
    cuffs = {name: one for name, one in traces.items() if one.cuff_force is not None}
    if cuffs:
        plots["cuff-forces"] = cuff_forces_plot(cuffs)
    named = f": {place}" if place else ""
    return {name: replace(plot, title=plot.title + named) for name, plot in plots.items()}


def trajectory_plot(traces: Traces) -> Plot:
    """Returns intended and actual angles of the assisted joints over time, a line per policy."""
    first, panels = next(iter(traces.values())), []
    for title, at in zip(TITLES, ASSISTED_COLUMNS, strict=True):
        marks: list[Mark] = [Line(first.time, first.target_angle[:, at], "intended", width=4)]
        marks += [Line(one.time, one.angle[:, at], name) for name, one in traces.items()]
        panels.append(Panel(x="time [s]", y=f"{title} [rad]", marks=marks, least=LEAST_HEIGHT))
    return Plot(title="Intended and actual angles", panels=panels, height=2.6)


def motion_loops_plot(traces: Traces) -> Plot:
    """Returns the suit's resistance over the joint angle, a line per policy."""
    panels = []
    for title, at in zip(TITLES, ASSISTED_COLUMNS, strict=True):
        loops = {name: (one.angle[:, at], -one.suit_torque[:, at]) for name, one in traces.items()}
        marks = [Line(*loop, name, width=1) for name, loop in loops.items()]
        panels.append(Panel(x="angle [rad]", y="suit resistance [N·m]", marks=marks, title=title))
    return Plot(title="Torque of the suit over angle", panels=panels, columns=len(ASSISTED))


def strain_plot(traces: Traces) -> Plot:
    """Returns effort, strength, fatigue and heat at the assisted joints, a line per policy.

    Strength is that of the weaker of a joint's muscles, fatigue that of the more fatigued.
    """
    at, of = ASSISTED_COLUMNS, traces.items()
    rows: dict[str, dict[str, Array]] = {
        "effort [% of strength]": {name: 100 * one.effort[:, at] for name, one in of},
        "strength [N·m]": {name: one.strength.min(axis=1)[:, at] for name, one in of},
        "fatigued [%]": {
            name: 100 * one.fatigue.max(axis=1)[:, at]
            for name, one in of
            if one.fatigue is not None
        },
        HEAT: {name: 100 * one.motor_load for name, one in of if one.motor_load is not None},
    }
    shown = {label: row for label, row in rows.items() if row}
    return _over_time("Effort, fatigue and heat", traces, shown, height=2.4, from_zero=True)


def cuff_forces_plot(traces: Traces) -> Plot:
    """Returns the forces of the cuffs over time, and the largest ones that a person should bear."""
    panels = []
    for i, (segment, limit) in enumerate(FORCE_LIMITS.items()):
        marks = [
            Line(one.time, np.linalg.norm(np.asarray(one.cuff_force)[:, i], axis=-1), name)
            for name, one in traces.items()
        ]
        levels = {"most that one should bear, ISO/TS 15066": limit}
        label = f"{segment.replace('_', ' ')} [N]"
        panels.append(Panel(x="time [s]", y=label, marks=marks, levels=levels, from_zero=True))
    return Plot(title="Forces of the cuffs", panels=panels, height=2.4)


def _over_time(
    title: str,
    traces: Traces,
    rows: Mapping[str, Mapping[str, Array]],
    height: float = 2.6,
    **options: Any,
) -> Plot:
    """Returns a row of panels for each quantity, a column for each assisted joint."""
    panels = []
    for label, row in rows.items():
        more = {**options, **({"levels": {"a motor is hot": 100.0}} if label == HEAT else {})}
        for i, joint in enumerate(TITLES):
            marks = [Line(traces[name].time, one[:, i], name) for name, one in row.items()]
            panels.append(Panel(x="time [s]", y=label, marks=marks, title=joint, **more))
    return Plot(title=title, panels=panels, columns=len(ASSISTED), height=height)


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
