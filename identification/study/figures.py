"""Figures 2 and 4-8 of Li et al. 2022 in a study's data, and evaluations to the target."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..curves import Curve, Curves, Role
from ..figures import COLORS, STYLES
from ..objective import CurveObjective
from ..thinning import drawn_note, drawn_samples
from .summary import Summary
from .trial import StudyConfig, is_multi_order

MARKS = (".", "x", "+", "^")
Families = Mapping[str, Sequence[Curve]]


def figures(
    config: StudyConfig, families: Families, summaries: Sequence[Summary]
) -> dict[str, Figure]:
    """Draws every figure of a study, by file name."""
    first_order = {
        joint: [curve for curve in curves if curve.role == "fit" or not is_multi_order(curve)]
        for joint, curves in families.items()
    }
    multi_order = {
        joint: motions
        for joint, curves in families.items()
        if (motions := [curve for curve in Curves(curves).held_out() if is_multi_order(curve)])
    }
    drawn = {
        "curves": _over_angle(first_order, [], "torque"),
        "convergence": convergence(config, summaries),
        "loops": _over_angle(families, summaries, "torque", "fit"),
        "ecdf": evaluations_to_target(config, summaries),
    }
    if any(Curves(curves).held_out() for curves in first_order.values()):
        drawn["prediction"] = _over_angle(first_order, summaries, "torque", "predict")
        drawn["prediction-errors"] = _over_angle(first_order, summaries, "error", "predict")
    if multi_order:
        drawn["multi-order"] = multi_order_prediction(multi_order, summaries)
    return drawn


def convergence(config: StudyConfig, summaries: Sequence[Summary]) -> Figure:
    """Draws the best fitness over evaluations: median, quartiles, and the best trial (dotted)."""
    figure, axes = _panels(list(config.joints))
    spent = np.unique(np.geomspace(1, config.evaluations, 400).astype(np.int64))
    for summary, ax, color, style in _drawn(summaries, axes, config):
        shown = spent[spent <= max(trial.evaluations for trial in summary.trials)]
        runs = np.array([trial.best_after(shown) for trial in summary.trials])
        low, middle, high = np.quantile(runs, [0.25, 0.5, 0.75], axis=0, method="higher")
        ax.fill_between(shown, low, high, color=color, alpha=0.2, lw=0)
        ax.plot(shown, middle, style, color=color, label=summary.method)
        ax.plot(shown, summary.best.best_after(shown), ":", color=color, lw=1)
    xlabel = f"model evaluations ({config.swarm_size} an iteration)"
    for ax in axes.values():
        ax.set(xscale="log", yscale="log", xlabel=xlabel)
    _finish(axes, "fitness, eq. (7): median, quartiles")
    return figure


def evaluations_to_target(config: StudyConfig, summaries: Sequence[Summary]) -> Figure:
    """Draws the share of trials within 5 % of the noise floor over the number of model runs."""
    figure, axes = _panels(list(config.joints))
    for summary, ax, color, style in _drawn(summaries, axes, config):
        reached = np.sort(summary.evaluations_to_target)
        reached = reached[np.isfinite(reached)]
        x = np.concatenate([[1], reached, [reached.max(initial=config.evaluations)]])
        y = np.append(np.arange(reached.size + 1), reached.size) / len(summary.trials)
        ax.step(x, y, style, where="post", color=color, label=summary.method)
    for ax in axes.values():
        ax.set(xscale="log", ylim=(-0.02, 1.02), xlabel="model evaluations on all curves")
    _finish(axes, "share of trials within 5 % of the noise")
    return figure


def multi_order_prediction(families: Families, summaries: Sequence[Summary]) -> Figure:
    """Draws the first motion of each joint, and the best models' torque and errors on it."""
    figure = Figure(figsize=(max(5.0 * len(families), 6.0), 6.4), layout="constrained")
    rows = figure.subplots(2, len(families), squeeze=False, height_ratios=[3, 2])
    for (joint, (motion, *_)), loops, errors in zip(families.items(), *rows, strict=True):
        (drawn,) = drawn_samples([motion])
        angle, measured = motion.angle[drawn], motion.torque[drawn]
        loops.plot(angle, measured, ".", ms=3, color="0.7", label="curve", zorder=0)
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(motion.angle)))])[drawn]
        for i, summary in enumerate(s for s in summaries if s.joint == joint):
            torque = _torque(summary, motion)[drawn]
            loops.plot(angle, torque, lw=1.2, label=summary.method, **_look(i))
            errors.plot(way, torque - measured, lw=0.6, **_look(i))
        loops.set_title(f"{_title(joint)}, {motion.name}", loc="left")
        loops.set_xlabel(_angle_label([motion]))
        errors.set_xlabel("angle traveled [rad]")
    for row, ylabel in zip(rows, ("resistance [N·m]", "model - curve [N·m]"), strict=True):
        _finish(dict(enumerate(row)), ylabel)
    return figure


def _over_angle(
    families: Families, summaries: Sequence[Summary], quantity: str, role: Role | None = None
) -> Figure:
    """Draws curves of one role, or all, and the best models' torque or error on them."""
    figure, axes = _panels(list(families))
    for joint, ax in axes.items():
        curves = [curve for curve in families[joint] if role in (None, curve.role)]
        ours = [summary for summary in summaries if summary.joint == joint]
        for i, (curve, drawn) in enumerate(zip(curves, drawn_samples(curves), strict=True)):
            angle, measured = curve.angle[drawn], curve.torque[drawn]
            if quantity == "torque":
                color = "0.7" if ours else COLORS[i % len(COLORS)]
                mark = "." if ours else MARKS[i // len(COLORS) % len(MARKS)]
                label = f"{curve.name} ({curve.role})" if not ours else "curves"
                ax.plot(angle, measured, mark, ms=3, color=color, label=label, zorder=0)
            for j, summary in enumerate(ours):
                torque = _torque(summary, curve)[drawn]
                shown = torque if quantity == "torque" else torque - measured
                width = 1.2 if quantity == "torque" else 0.7  # errors are mostly noise
                ax.plot(angle, shown, lw=width, label=summary.method, **_look(j))
        ax.axhline(0, color="0.6", lw=0.6)
        ax.set_xlabel(_angle_label(curves))
    _finish(axes, "resistance [N·m]" if quantity == "torque" else "model - curve [N·m]")
    return figure


def _angle_label(curves: Sequence[Curve]) -> str:
    note = drawn_note(curves)
    return f"angle [rad] ({note})" if note else "angle [rad]"


def _torque(summary: Summary, curve: Curve) -> NDArray[np.float64]:
    """Returns the best model's torque along a curve [N·m], nan where it meets its pole."""
    torque = CurveObjective([curve]).responses(summary.best.parameters)[0]
    torque[~np.isfinite(torque)] = np.nan
    return torque


def _panels(joints: Sequence[str]) -> tuple[Figure, dict[str, Any]]:
    figure = Figure(figsize=(max(5.0 * len(joints), 6.0), 3.8), layout="constrained")
    grid = figure.subplots(1, len(joints), squeeze=False)[0]
    for ax, joint in zip(grid, joints, strict=True):
        ax.set_title(_title(joint), loc="left")
    return figure, dict(zip(joints, grid, strict=True))


def _drawn(summaries: Sequence[Summary], axes: Mapping[str, Any], config: StudyConfig):
    for summary in summaries:
        look = _look(config.methods.index(summary.method))
        yield summary, axes[summary.joint], look["color"], look["linestyle"]


def _look(i: int) -> dict[str, str]:
    return {
        "color": COLORS[i % len(COLORS)],
        "linestyle": STYLES[i // len(COLORS) % len(STYLES)],
    }


def _title(joint: str) -> str:
    return joint.replace("_", " ")


def _finish(axes: Mapping[Any, Any], ylabel: str) -> None:
    for ax in axes.values():
        ax.grid(alpha=0.25)
        handles, labels = ax.get_legend_handles_labels()
        once = dict(zip(labels, handles, strict=True))
        if once:
            ax.legend(once.values(), once.keys(), frameon=False, fontsize=8)
    next(iter(axes.values())).set_ylabel(ylabel)
