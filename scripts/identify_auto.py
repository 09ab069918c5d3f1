"""`activesuit identify --method auto`: which model, and why."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..identification import AutoFit, Curve, identify_auto
from ..identification.figures import loops_figure
from .output import RunFolder, table, to_json


def report_auto(
    curves: Path, family: Sequence[Curve], seed: int, out: Path | None, json: bool
) -> None:
    """Chooses a model for a family of curves, prints why, and writes model and loops."""
    folder = RunFolder(out) if out else None
    fit = identify_auto(family, seed=seed)
    summary = _summary(fit, family, seed)
    if json:
        print(to_json(summary))
    else:
        table(
            f"models for {curves.name}",
            ["model", "numbers", "predicts:\nNRMSE", "fits:\nNRMSE", "note"],
            [
                [
                    one.name,
                    str(one.parameters) if one.model else "-",
                    f"{one.prediction_nrmse:.2%}" if one.model else "-",
                    f"{one.fit_nrmse:.2%}" if one.model else "-",
                    "chosen" if one.name == fit.name else one.reason,
                ]
                for one in fit.candidates
            ],
            left=1,
        )
        print(fit.why)
        for name, error in summary["prediction_max_error"].items():
            print(f"largest error on the held-out curve {name}: {error:.2f} N·m")
    if folder:
        folder.json("model.json", summary["model"])
        folder.json("result.json", summary)
        loops = loops_figure({curves.stem: list(family)}, {curves.stem: {fit.name: fit.model}})
        folder.figure("loops", loops)
        if not json:
            print(f"wrote {folder.path}/model.json, result.json, loops.png")


def _summary(fit: AutoFit, family: Sequence[Curve], seed: int) -> dict[str, Any]:
    held_out = [curve for curve in family if curve.role == "predict"]
    certificate = fit.model.certificate()
    return {
        "method": "auto",
        "seed": seed,
        "chosen": fit.name,
        "why": fit.why,
        "model": fit.model.to_dict(),
        "first_torque": fit.first_torque,
        "certified": certificate.certified and certificate.dissipative,
        "prediction_max_error": {
            curve.name: float(np.abs(_error(fit, curve)).max()) for curve in held_out
        },
        "candidates": [
            {
                "name": one.name,
                "parameters": one.parameters,
                "prediction_nrmse": one.prediction_nrmse,
                "fit_nrmse": one.fit_nrmse,
                "failed": one.reason or None,
            }
            for one in fit.candidates
        ],
    }


def _error(fit: AutoFit, curve: Curve) -> np.ndarray:
    return fit.model.response(curve.angle, fit.first_torque) - curve.torque
