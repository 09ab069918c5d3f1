"""`activesuit identify`: a model from a file of measured curves."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import tyro

from ..assets import Suit, load_suit, save_suit
from ..errors import InputError
from ..hysteresis import Held
from ..hysteresis.jiles_atherton import PARAMETERS
from ..identification import Fit, Trial, bare, load_curves
from ..identification import identify as identify_curves
from ..identification.figures import loops_figure
from .identify_auto import report_auto
from .output import RunFolder, progress, table, to_json
from .suit_export import fitted_joint, joint_of
from .tables import parameter_table, quality_table

Method = Literal[
    "certified",
    "auto",
    "sa-pso",
    "mpso",
    "pso",
    "rank-distance-mpso",
    "de",
    "dual-annealing",
    "nelder-mead",
    "ga",
    "cma-es",
]


def identify(
    curves: Annotated[Path, tyro.conf.Positional],
    /,
    method: Method = "certified",
    trials: int | None = None,
    seed: int = 0,
    workers: int = -1,
    joint: str | None = None,
    base: str | None = None,
    out: Path | None = None,
    json: bool = False,
) -> None:
    """Identify a hysteresis model from measured angle-torque curves.

    Curves with role "predict" are kept out of the fit and used to test it.

    Args:
        curves: CSV file with the columns curve, angle_rad (or angle_deg), torque_nm, and
            optionally role (fit or predict).
        method: certified (a Jiles-Atherton model that is safe to simulate), auto (the simplest of
            all models that predicts well), a swarm of the papers, or another library's optimizer
            (ga and cma-es need the extra `compare`).
        trials: independent runs, of which the best counts; by default 1 for certified, 30 for the
            others; auto makes one.
        seed: fixes all random numbers.
        workers: threads; -1 uses all cores.
        joint: which joint the curves belong to: shoulder_abduction, shoulder_flexion,
            elbow_flexion or wrist_flexion; by default the file name tells (elbow.csv).
        base: suit whose other joints suit.json takes over; by default it has this one only.
        out: folder for suit.json (auto: model.json), result.json, trials.csv and the loops as PNG
            and SVG.
        json: print the result as JSON.
    """
    family = load_curves(curves)
    if base and not out:
        raise InputError(f"--base {base} needs --out: its joints go into suit.json there")
    if method == "auto":
        report_auto(curves, family, seed, out, json)
        return
    joint_name = joint_of(curves, joint) if out or joint else None
    others = load_suit(base).joints if base else {}
    folder = RunFolder(out) if out else None
    total = trials or (1 if method == "certified" else 30)
    with progress(f"{method} on {curves.name}", total) as bar:

        def report(trial: Trial) -> None:
            del trial
            bar.advance()

        fit = identify_curves(
            family, method=method, trials=trials, seed=seed, workers=workers, on_trial=report
        )
    _print(fit, curves, seed, json)
    if folder and joint_name:
        suit = Suit(
            schema_version=1,
            name=curves.stem,
            description=_description(fit, curves, seed, total),
            joints={**others, joint_name: fitted_joint(fit, family, curves)},
        )
        _write(folder, suit, fit, seed)
        models = {joint_name: {method: fit.model}}
        folder.figure("loops", loops_figure({joint_name: family}, models))
        if not json:
            print(f"wrote {folder.path}/suit.json, result.json, trials.csv, loops.png")
    if fit.interrupted:
        raise KeyboardInterrupt(f"the best of the {len(fit.trials)} finished trials is kept")


def _print(fit: Fit, curves: Path, seed: int, json: bool) -> None:
    if json:
        print(to_json(fit_summary(fit, seed)))
        return
    table(curves.name, *parameter_table({curves.stem: {fit.method: fit}}))
    table("quality", *quality_table({curves.stem: {fit.method: fit}}))
    for remark in fit.remarks:
        print(f"note: {remark}")


def _description(fit: Fit, curves: Path, seed: int, trials: int) -> str:
    text = f"Identified from {curves.name} by {fit.method}, seed {seed}"
    if fit.interrupted:
        text += f", interrupted after {len(fit.trials)} of {trials} trials"
    return f"{text}."


def _write(folder: RunFolder, suit: Suit, fit: Fit, seed: int) -> None:
    save_suit(suit, folder / "suit.json")
    folder.json("result.json", fit_summary(fit, seed))
    write_trials(folder, "trials.csv", {suit.name: {fit.method: fit}})


def fit_summary(fit: Fit, seed: int) -> dict:
    """Returns a fit as plain values for JSON."""
    certificate, inner = fit.model.certificate(), bare(fit.model)
    return {
        "method": fit.method,
        "seed": seed,
        "model": "jiles-atherton",
        "parameters": {name: getattr(inner, name) for name in PARAMETERS},
        "angle_unit": inner.angle_unit,
        "held_outside": fit.model.angle_range if isinstance(fit.model, Held) else None,
        "fitness": fit.fitness,
        "nrmse": fit.nrmse,
        "prediction_max_error": fit.prediction_errors,
        "evaluations": fit.evaluations,
        "trials": len(fit.trials),
        "interrupted": fit.interrupted,
        "remarks": fit.remarks,
        "certificate": {**asdict(certificate), "certified": certificate.certified},
    }


def write_trials(folder: RunFolder, name: str, fits: dict[str, dict[str, Fit]]) -> None:
    """Writes every trial of every fit as one CSV row."""
    header = ["curves", "method", "trial", "Ms", "a", "alpha", "c", "k", "nrmse", "evaluations"]
    folder.csv(
        name,
        header,
        (
            [curves, method, trial.index, *trial.parameters, trial.nrmse, trial.evaluations]
            for curves, methods in fits.items()
            for method, fit in methods.items()
            for trial in fit.trials
        ),
    )
