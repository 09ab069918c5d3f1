"""The tables that commands print and reports repeat: as header and rows of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...hysteresis import HysteresisModel, JilesAtherton
from ...hysteresis.around.wrapper import Wrapper

if TYPE_CHECKING:  # `activesuit suits` needs none of these
    from ...envs.evaluation import Score
    from ...identification import Fit
    from ...identification.uncertainty.uncertainty import Uncertainty

Rows = tuple[list[str], list[list[str]]]

FEW = 6  # numbers that a cell lists
UNITS = {
    "Ms": "N·m",
    "elastic": "N·m/rad",
    "hysteretic": "N·m/rad",
    "beta": "1/rad^n",
    "gamma": "1/rad^n",
    "stiffness": "N·m/rad",
    "weights": "N·m/rad",
    "thresholds": "rad",
    "rest_angle": "rad",
    "levels": "rad",
    "density": "N·m",
    "polynomial": "N·m/rad^i",
    "angle_range": "rad",
    "initial_torque": "N·m",
}
DEGREES = {"a": "deg", "alpha": "deg/N·m", "k": "deg"}


def parameter_table(models: Mapping[str, HysteresisModel]) -> Rows:
    """One column per model, by label; one row per parameter, Jiles-Atherton's in degrees."""
    columns = [{"model": _kind(model), **_parameters(model)} for model in models.values()]
    names = dict.fromkeys(name for column in columns for name in column)
    rows = [[name, *(column.get(name, "-") for column in columns)] for name in names]
    return ["", *models], rows


def _kind(model: HysteresisModel) -> str:
    name = model.name.replace("-", "-\n")
    return f"{name}\n{_kind(model.model)}" if isinstance(model, Wrapper) else name


def _parameters(model: HysteresisModel) -> dict[str, str]:
    """Returns the parameters of a model as text, by name and unit; many numbers by their range."""
    inner, units = {}, UNITS
    if isinstance(model, Wrapper):
        inner = _parameters(model.model)
    elif isinstance(model, JilesAtherton):
        model, units = model.in_unit("deg"), UNITS | DEGREES
    content = model.to_dict()
    own = {
        f"{name} [{units[name]}]" if name in units else name: _text(value)
        for name, value in content.items()
        if name not in ("model", "hysteresis", "angle_unit")
    }
    return inner | own


def _text(value: Any) -> str:
    if isinstance(value, (bool, str)):
        return str(value)
    numbers = np.concatenate([np.atleast_1d(row) for row in np.atleast_1d(np.array(value, object))])
    if numbers.size > FEW:
        return f"{numbers.size} numbers,\n{numbers.min():.4g} to {numbers.max():.4g}"
    return "\n".join(f"{number:.5g}" for number in numbers)


def uncertainty_table(found: Uncertainty) -> Rows:
    """One row per parameter: value, standard error and 95 % interval; angles in degrees."""
    header = ["parameter", "value", "standard\nerror", "95 % interval"]
    units = UNITS | DEGREES
    rows = []
    for i, name in enumerate(found.names):
        label = f"{name} [{units[name]}]" if name in units else name
        low, high = found.intervals[i]
        rows.append(
            [
                label,
                f"{found.values[i]:.5g}",
                f"{found.standard_errors[i]:.2g}",
                f"{low:.5g} .. {high:.5g}",
            ]
        )
    return header, rows


def candidate_table(fit: Fit) -> Rows:
    """One row per model that method "auto" tried, the best prediction first."""
    header = ["model", "parameters", "predicts:\nNRMSE", "fits:\nNRMSE", "note"]
    rows = []
    for one in fit.candidates:
        scores = ["-"] * 3
        if one.model:
            scores = [str(one.parameters), f"{one.prediction_nrmse:.2%}", f"{one.fit_nrmse:.2%}"]
        rows.append([one.name, *scores, "chosen" if one.name == fit.model_name else one.reason])
    return header, rows


def quality_table(fits: Mapping[str, Mapping[str, Fit]]) -> Rows:
    """One row per family of curves and method: scores, certificate, cost and prediction."""
    header = ["curves", "method", "fitness,\neq. (7)", "NRMSE", "margin"]
    header += ["model\nruns", "held-out\nmax [N·m]"]
    rows = []
    for joint, methods in fits.items():
        for method, fit in methods.items():
            errors = fit.prediction_errors.items()
            held_out = (f"{name}: {error:.2f}" for name, error in errors)
            rows.append(
                [
                    joint,
                    method,
                    f"{fit.fitness:.2e}",
                    f"{fit.nrmse:.2%}",
                    f"{fit.model.certificate().margin:.3f}",
                    "-" if fit.evaluations is None else f"{fit.evaluations:,}",
                    "\n".join(held_out) or "-",
                ]
            )
    return header, rows


def score_table(scores: Sequence[Score]) -> Rows:
    """Two rows per policy, shoulder and elbow: the wearer's torque, tracking, cost."""
    from ...envs.model import ASSISTED

    header = ["policy", "joint", "RMS\n[N·m]", "peak\n[N·m]", "RMS\nsaved"]
    header += ["error\n[rad]", "assist\n[J]", "return"]
    rows = []
    for score in scores:
        failed = f" ({score.failures} failed)" if score.failures else ""
        episode = [f"{score.assist_energy:.1f}", f"{score.mean_return:.0f}"]
        for i, joint in enumerate(ASSISTED):
            rows.append(
                [
                    score.policy + failed if i == 0 else "",
                    joint.removesuffix("_flexion"),
                    f"{score.human_rms[joint]:.2f}",
                    f"{score.human_peak[joint]:.2f}",
                    "-" if score.reduction is None else f"{score.reduction[joint]:.1%}",
                    f"{score.tracking_rmse[joint]:.4f}",
                    *(episode if i == 0 else ("", "")),
                ]
            )
    return header, rows


def effort_table(scores: Sequence[Score]) -> Rows:
    """Two rows per policy: what the motion costs the wearer, per episode."""
    from ...envs.model import ASSISTED

    header = ["policy", "joint", "impulse\n[N·m·s]", "work on\nthe arm [J]", "taken\n[J]"]
    header += ["cost of\ntorque", "cost of\nwork [J]", "smoothness\nSPARC"]
    rows = []
    for score in scores:
        for i, joint in enumerate(ASSISTED):
            cost = score.effort[joint]
            rows.append(
                [
                    score.policy if i == 0 else "",
                    joint.removesuffix("_flexion"),
                    f"{cost['impulse']:.1f}",
                    f"{cost['positive_work']:.2f}",
                    f"{cost['negative_work']:.2f}",
                    f"{cost['torque_cost']:.0f}",
                    f"{cost['work_cost']:.1f}",
                    f"{cost['spectral_arc_length']:.2f}",
                ]
            )
    return header, rows


def cuff_remarks(scores: Sequence[Score]) -> list[str]:
    """One sentence per policy with cuffs: their greatest forces, and what a person should bear."""
    from ...envs.model.cuffs import FORCE_LIMITS

    return [
        f"{score.policy}: cuff forces up to "
        + ", ".join(
            f"{force:.0f} N ({segment.replace('_', ' ')}; at most {FORCE_LIMITS[segment]:.0f})"
            for segment, force in score.cuff_peak.items()
        )
        for score in scores
        if score.cuff_peak
    ]
