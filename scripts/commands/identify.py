"""`activesuit identify`: a model from a file of measured curves."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from ...assets import Suit, load_suit, save_suit
from ...checks import at_least
from ...errors import InputError
from ...identification import Candidate, Curve, Fit, Trial, load_curves
from ...identification import identify as identify_curves
from ...identification.figures import loops_figure
from ...identification.objective import InitialTorque
from ...identification.uncertainty.uncertainty import Uncertainty, uncertainty
from ..output import RunFolder, progress, table, to_json
from ..reports.tables import candidate_table, parameter_table, quality_table, uncertainty_table
from ..suit_export import fitted_joint, joint_of

Model = Literal["jiles-atherton", "asymmetric", "bouc-wen", "prandtl-ishlinskii", "preisach"]
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
    model: Model | None = None,
    method: Method = "certified",
    objective: Literal["nrmse", "paper", "sse", "robust"] | None = None,
    normalize: Literal["family", "curve"] | None = None,
    initial_torque: float | Literal["measured", "identified"] | None = None,
    trials: int | None = None,
    seed: int = 0,
    workers: int = -1,
    samples: int = 0,
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
        model: jiles-atherton (by default), asymmetric (the same beside a polynomial), bouc-wen,
            prandtl-ishlinskii or preisach; all but the first by method certified only.
        method: certified (a model that is safe to simulate), auto (the simplest of all models that
            predicts curves left out of its fit), a swarm of the papers, or another library's
            optimizer (ga and cma-es need the extra `compare`).
        objective: what a swarm or optimizer minimizes: nrmse (by default), paper (eq. 7 of Li et
            al. 2022), sse, or robust (against outliers).
        normalize: of the objective: errors over the largest torque of the family (by default) or
            of each curve.
        initial_torque: with which each curve begins: a number in N·m (by default 0), measured (its
            first sample) or identified (one for all). The fits of other models than jiles-atherton
            always identify it.
        trials: independent runs, of which the best counts; by default 1 for certified, 30 for
            swarms and optimizers.
        seed: fixes all random numbers.
        workers: threads; -1 uses all cores.
        samples: how many models that the curves also allow go into suit.json, to randomize with;
            also shows how sure the parameters are (jiles-atherton only).
        joint: which joint the curves belong to: shoulder_abduction, shoulder_flexion,
            elbow_flexion or wrist_flexion; by default the file name tells (elbow.csv).
        base: suit whose other joints suit.json takes over; by default it has this one only.
        out: folder for suit.json, result.json, trials.csv and the loops as PNG and SVG.
        json: print the result as JSON.
    """
    family = load_curves(curves)
    if base and not out:
        raise InputError(f"--base {base} needs --out: its joints go into suit.json there")
    _check_samples(samples, method, model)
    joint_name = joint_of(curves, joint) if out or joint else None
    others = load_suit(base).joints if base else {}
    folder = RunFolder(out) if out else None
    total = trials or (1 if method in ("certified", "auto") else 30)
    with progress(f"{method} on {curves.name}", total) as bar:

        def report(trial: Trial) -> None:
            del trial
            bar.advance()

        fit = identify_curves(
            family,
            model=model,
            method=method,
            objective=objective,
            normalize=normalize,
            initial_torque=initial_torque,
            trials=trials,
            seed=seed,
            workers=workers,
            on_trial=report,
        )
    summary = fit_summary(fit, seed)
    found = _uncertainty(fit, family, initial_torque or 0.0, samples, seed) if samples else None
    if found:
        summary["uncertainty"] = _uncertainty_summary(found)
    if json:
        print(to_json(summary))
    else:
        _print(fit, curves, found)
    if folder and joint_name:
        drawn = found.samples if found else ()
        entry = fitted_joint(fit, family, curves, samples=drawn)
        description = _description(fit, curves, seed)
        joints = {**others, joint_name: entry}
        save_suit(
            Suit(name=curves.stem, description=description, joints=joints), folder / "suit.json"
        )
        folder.json("result.json", summary)
        _write(folder, joint_name, family, fit)
        if not json:
            print(f"wrote {folder.path}/suit.json, result.json, trials.csv, loops.png")
    if fit.interrupted:
        raise KeyboardInterrupt(f"the best of the {_finished(fit)} is kept")


def _check_samples(samples: int, method: Method, model: Model | None) -> None:
    at_least("samples", samples, 0)
    if samples and (method not in ("certified", "auto") or model not in (None, "jiles-atherton")):
        raise InputError(
            f"--samples is {samples}: samples are drawn of certified fits of jiles-atherton only; "
            "leave it out"
        )


def _print(fit: Fit, curves: Path, found: Uncertainty | None) -> None:
    if fit.candidates:
        table(f"models for {curves.name}", *candidate_table(fit), left=1)
        print(f"{fit.why}\n")
    header, rows = parameter_table({"value": fit.model})
    start = fit.initial_torque
    begins = start if isinstance(start, str) else f"{start:.5g}"
    table(curves.name, header, [*rows, ["initial torque [N·m]", begins]], left=1)
    table("quality", *quality_table({curves.stem: {fit.method: fit}}))
    if found:
        table("how sure the parameters are", *uncertainty_table(found), left=1)
    for remark in (*fit.remarks, *(found.sloppy if found else ())):
        print(f"note: {remark}")


def _description(fit: Fit, curves: Path, seed: int) -> str:
    text = f"Identified from {curves.name} by {fit.method}, seed {seed}"
    if fit.interrupted:
        text += f", interrupted: the best of the {_finished(fit)}"
    return f"{text}."


def _finished(fit: Fit) -> str:
    if fit.candidates:
        return f"{len(fit.candidates)} models tried so far"
    return f"{len(fit.trials)} finished trials"


def _write(folder: RunFolder, joint: str, family: Sequence[Curve], fit: Fit) -> None:
    write_trials(folder, "trials.csv", {joint: {fit.method: fit}})
    folder.figure("loops", loops_figure({joint: family}, {joint: {fit.model_name: fit}}))


def fit_summary(fit: Fit, seed: int) -> dict[str, Any]:
    """Returns a fit as plain values for JSON."""
    certificate = fit.model.certificate()
    return {
        "method": fit.method,
        "seed": seed,
        "model_name": fit.model_name,
        "model": fit.model.to_dict(),
        "initial_torque": fit.initial_torque,
        "fitness": fit.fitness,
        "nrmse": fit.nrmse,
        "prediction_max_error": fit.prediction_errors,
        "evaluations": fit.evaluations,
        "trials": len(fit.trials),
        "interrupted": fit.interrupted,
        "remarks": fit.remarks,
        "certificate": {**asdict(certificate), "certified": certificate.certified},
        "why": fit.why,
        "candidates": [_candidate_summary(one) for one in fit.candidates],
    }


def _uncertainty(
    fit: Fit, curves: Sequence[Curve], initial_torque: InitialTorque, samples: int, seed: int
) -> Uncertainty:
    if fit.model_name != "jiles-atherton":
        raise InputError(
            f"--samples is {samples}, but the chosen model is {fit.model_name!r}: samples are "
            "drawn of jiles-atherton only; leave it out"
        )
    return uncertainty(fit.model, curves, initial_torque=initial_torque, samples=samples, seed=seed)


def _uncertainty_summary(found: Uncertainty) -> dict[str, Any]:
    return {
        "names": found.names,
        "values": found.values,
        "standard_errors": found.standard_errors,
        "intervals": found.intervals,
        "condition": found.condition,
        "sloppy": found.sloppy,
        "samples": [sample.to_dict() for sample in found.samples],
    }


def _candidate_summary(one: Candidate) -> dict[str, Any]:
    return {
        "name": one.name,
        "parameters": one.parameters,
        "prediction_nrmse": one.prediction_nrmse,
        "fit_nrmse": one.fit_nrmse,
        "failed": one.reason or None,
    }


def write_trials(folder: RunFolder, name: str, fits: Mapping[str, Mapping[str, Fit]]) -> None:
    """Writes every trial of every fit as one CSV row, angles of Jiles-Atherton in degrees."""
    rows = [
        {
            "curves": curves,
            "method": method,
            "trial": trial.index,
            "nrmse": trial.nrmse,
            "evaluations": trial.evaluations,
            "initial_torque": trial.initial_torque,
            **dict(_numbers("", trial.model.to_dict())),
        }
        for curves, methods in fits.items()
        for method, fit in methods.items()
        for trial in fit.trials
    ]
    header = list(dict.fromkeys(name for row in rows for name in row))
    folder.csv(name, header, ([row.get(column) for column in header] for row in rows))


def _numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    """Yields the numbers in a model's dictionary by name, those in lists as name[i]."""
    if isinstance(value, Mapping):
        for key, item in value.items():
            yield from _numbers(key, item)
    elif isinstance(value, (list, tuple)):
        for i, item in enumerate(value):
            yield from _numbers(f"{name}[{i}]", item)
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield name, value
