"""Figures 2 and 4 to 8 of Li et al. (2022) in our data."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..identification import Curve
from .results import panels

if TYPE_CHECKING:
    from .li_2022 import Runs

COLORS = {"sa-pso": "#0072b2", "mpso": "#d55e00", "certified": "#009e73"}  # what is drawn


def drawn(found: Sequence["Runs"]) -> dict[str, Figure | str]:
    """Returns all figures of the paper, or what those without data show."""
    joints: dict[str, list[Runs]] = {}
    for one in found:
        if one.method in COLORS:
            joints.setdefault(one.joint, []).append(one)
    held_out = [
        (runs, curve) for runs in joints.values() for curve in runs[0].fit.curves.held_out()
    ]
    figures: dict[str, Figure | str] = {
        "Fig. 1": "a drawing of the exoskeleton, without data",
        "Fig. 2": _curves(joints),
        "Fig. 3": "the flow chart of SA-PSO, which is activesuit.identification.sa_pso",
        "Fig. 4": _convergence(joints),
    }
    for i, runs in enumerate(joints.values(), 5):
        figures[f"Fig. {i}"] = _loops([(runs, curve) for curve in runs[0].fit.curves.fitted()])
    figures["Fig. 7"] = _loops(held_out, rows=2)
    figures["Fig. 8"] = _loops(held_out, rows=2, errors=True)
    figures["Section 6"] = _loops([(runs, runs[0].motions[0]) for runs in joints.values()])
    return figures


def _curves(joints: dict[str, list["Runs"]]) -> Figure:
    figure, axes = panels([*joints], "resistance [N·m]")
    for ax, (one, *_) in zip(axes, joints.values(), strict=True):
        for curve in one.fit.curves:
            ax.plot(curve.angle, curve.torque, ".", ms=2, label=f"to {curve.name} ({curve.role})")
        ax.set_xlabel("angle [rad]")
        ax.legend(frameon=False, fontsize=8)
    return figure


def _convergence(joints: dict[str, list["Runs"]]) -> Figure:
    label = "fitness, eq. (7)\nmedian, quartiles, best (dotted)"
    figure, axes = panels([*joints], label, sharey=True)
    for ax, runs in zip(axes, joints.values(), strict=True):
        for one in runs:
            histories = np.array([trial.history for trial in one.fit.trials])
            color = COLORS[one.method]
            if not histories.size:  # the certified fit has no iterations
                ax.axhline(np.median(one.fitness), color=color, lw=1, label=one.method)
                continue
            low, middle, high = np.quantile(histories, [0.25, 0.5, 0.75], axis=0)
            ax.fill_between(np.arange(middle.size), low, high, color=color, alpha=0.2, lw=0)
            ax.plot(middle, color=color, label=one.method)
            ax.plot(histories[one.best], ":", color=color, lw=1)
        ax.set(yscale="log", xlabel="iteration")
    axes[0].legend(frameon=False, fontsize=8)
    return figure


def _loops(
    shown: Sequence[tuple[list["Runs"], Curve]], rows: int = 1, errors: bool = False
) -> Figure:
    """Draws the best model of each method on a curve a panel, or its errors."""
    titles = [f"{runs[0].joint}, curve {curve.name}" for runs, curve in shown]
    figure, axes = panels(titles, "model - curve [N·m]" if errors else "resistance [N·m]", rows)
    for ax, (runs, curve) in zip(axes, shown, strict=True):
        if not errors:
            ax.plot(curve.angle, curve.torque, ".", ms=3, color="0.7", label="curve")
        for one in runs:
            torque = one.fit.predict(curve) - (curve.torque if errors else 0)
            torque = np.where(np.isfinite(torque), torque, np.nan)  # a gap at the pole
            ax.plot(curve.angle, torque, lw=0.9, color=COLORS[one.method], label=one.method)
        ax.set_xlabel("angle [rad]")
    axes[0].legend(frameon=False, fontsize=8)
    return figure
