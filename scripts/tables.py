"""The tables that commands print and reports repeat: as header and rows of text."""

from collections.abc import Mapping, Sequence

from ..envs.composition import ASSISTED
from ..envs.evaluation import Score
from ..identification import Fit, bare

Rows = tuple[list[str], list[list[str]]]


def parameter_table(fits: Mapping[str, Mapping[str, Fit]]) -> Rows:
    """One row per joint and method: the parameters; a, alpha and k in degrees."""
    header = ["curves", "method", "Ms [N·m]", "a [deg]", "alpha\n[deg/N·m]", "c", "k [deg]"]
    rows = []
    for joint, methods in fits.items():
        for method, fit in methods.items():
            model = bare(fit.model).in_unit("deg")
            values = (model.Ms, model.a, model.alpha, model.c, model.k)
            rows.append([joint, method, *(f"{value:.5g}" for value in values)])
    return header, rows


def quality_table(fits: Mapping[str, Mapping[str, Fit]]) -> Rows:
    """One row per joint and method: scores, certificate, cost and prediction."""
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
                    f"{fit.evaluations:,}",
                    "\n".join(held_out) or "-",
                ]
            )
    return header, rows


def score_table(scores: Sequence[Score]) -> Rows:
    """Two rows per policy, shoulder and elbow: the wearer's torque, tracking, cost."""
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
