"""Figures 2 and 4-8 of Li et al. 2022 in a study's data, and evaluations to the target."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .curves import Curve, Role
from .figures import COLORS, STYLES
from .objective import CurveObjective
from .study import StudyConfig
from .study_summary import Summary

Families = Mapping[str, Sequence[Curve]]


def figures(
    config: StudyConfig, families: Families, summaries: Sequence[Summary]
) -> dict[str, Figure]:
    """Draws every figure of a study, by file name."""
    drawn = {
        "curves": _over_angle(families, [], "torque"),
        "convergence": convergence(config, summaries),
        "loops": _over_angle(families, summaries, "torque", "fit"),
        "ecdf": evaluations_to_target(config, summaries),
    }
    if any(curve.role == "predict" for curves in families.values() for curve in curves):
        drawn["prediction"] = _over_angle(families, summaries, "torque", "predict")
        drawn["prediction-errors"] = _over_angle(families, summaries, "error", "predict")
    return drawn


def convergence(config: StudyConfig, summaries: Sequence[Summary]) -> Figure:
    """Draws the best fitness over iterations: median and quartiles, and the best trial (dotted)."""
    figure, axes = _panels(list(config.joints))
    iteration = np.arange(1, config.iterations + 2)
    for summary, ax, color, style in _drawn(summaries, axes, config):
        if summary.convergence is None:
            continue
        size = config.swarm_size, config.iterations
        runs = np.array([trial.history(*size) for trial in summary.trials])
        low, middle, high = np.quantile(runs, [0.25, 0.5, 0.75], axis=0, method="higher")
        ax.fill_between(iteration, low, high, color=color, alpha=0.2, lw=0)
        ax.plot(iteration, middle, style, color=color, label=summary.method)
        ax.plot(iteration, summary.best.history(*size), ":", color=color, lw=1)
    for ax in axes.values():
        ax.set(yscale="log", xlabel=f"iteration ({config.swarm_size} evaluations)")
    _finish(axes, "fitness, eq. (7): median, quartiles")
    return figure


def evaluations_to_target(config: StudyConfig, summaries: Sequence[Summary]) -> Figure:
    """Draws which share of the trials was within 5 % of the noise floor after how many runs."""
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


def _over_angle(
    families: Families, summaries: Sequence[Summary], quantity: str, role: Role | None = None
) -> Figure:
    """Draws curves of one role, or all, and the best models' torque or error on them."""
    figure, axes = _panels(list(families))
    for joint, ax in axes.items():
        curves = [curve for curve in families[joint] if role in (None, curve.role)]
        ours = [summary for summary in summaries if summary.joint == joint]
        for i, curve in enumerate(curves):
            if quantity == "torque":
                color = "0.7" if ours else COLORS[i % len(COLORS)]
                label = f"{curve.name} ({curve.role})" if not ours else "curves"
                ax.plot(curve.angle, curve.torque, ".", ms=3, color=color, label=label, zorder=0)
            for j, summary in enumerate(ours):
                torque = CurveObjective([curve]).responses(summary.best.parameters)[0]
                torque[~np.isfinite(torque)] = np.nan
                shown = torque if quantity == "torque" else torque - curve.torque
                ax.plot(curve.angle, shown, lw=1.2, label=summary.method, **_look(j))
        ax.axhline(0, color="0.6", lw=0.6)
        ax.set_xlabel("angle [rad]")
    _finish(axes, "resistance [N·m]" if quantity == "torque" else "model - curve [N·m]")
    return figure


def _panels(joints: Sequence[str]) -> tuple[Figure, dict[str, Any]]:
    figure = Figure(figsize=(max(5.0 * len(joints), 6.0), 3.8), layout="constrained")
    grid = figure.subplots(1, len(joints), squeeze=False)[0]
    for ax, joint in zip(grid, joints, strict=True):
        ax.set_title(joint.replace("_", " "), loc="left")
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


def _finish(axes: Mapping[str, Any], ylabel: str) -> None:
    for ax in axes.values():
        ax.grid(alpha=0.25)
        handles, labels = ax.get_legend_handles_labels()
        once = dict(zip(labels, handles, strict=True))
        if once:
            ax.legend(once.values(), once.keys(), frameon=False, fontsize=8)
    next(iter(axes.values())).set_ylabel(ylabel)
