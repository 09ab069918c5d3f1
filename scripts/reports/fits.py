"""Fits as tables, as plain values for JSON, and as rows of a CSV file."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ...errors import InputError
from ...hysteresis.around import Wrapper
from ...hysteresis.protocol import HysteresisModel
from ...identification import Candidate, Fit, Remark, Selection
from ...identification.residual.verdict import DESCRIBES
from ...identification.uncertainty.uncertainty import Uncertainty
from ..output import Rows, RunFolder
from .parameters import labeled

MOST_ROWS = 20  # limit of a table on the screen


def quality_table(fits: Mapping[str, Mapping[str, Fit]]) -> Rows:
    """Returns one row per curve family and method: errors, certificate, cost and prediction."""
    header = ["curves", "method", "fitness,\neq. (7)", "NRMSE", "margin"]
    header += ["model\nruns", "starts that\nagree", "held-out\nmax [N·m]"]
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
                    "-" if fit.agreed is None else f"{fit.agreed} of {fit.starts}",
                    "\n".join(held_out) or "-",
                ]
            )
    return header, rows


def candidate_table(selection: Selection) -> Rows:
    """Returns one row per model that was tried, the best prediction first."""
    header = ["model", "parameters", "predicts:\nNRMSE", "fits:\nNRMSE", "weight\nin band", "note"]
    members = selection.ensemble.members if selection.ensemble else ()
    weight = {member.name: f"{member.weight:.0%}" for member in members}
    rows = []
    for one in selection.candidates:
        scores = ["-"] * 3
        if one.model:
            scores = [str(one.parameters), f"{one.prediction_nrmse:.2%}", f"{one.fit_nrmse:.2%}"]
        note = "chosen" if one.name == selection.fit.model_name else one.reason
        rows.append([one.name, *scores, weight.get(one.name, "-"), note])
    return header, rows


def band_table(bands: Mapping[str, Mapping[str, Any]]) -> Rows:
    """Returns one row per curve that was kept out of the fit, see `bands_of`."""
    header = ["curve", "half width\n[N·m]", "measured samples inside,\nnoise added"]
    rows = [
        [name, "none", band["why"]]
        if "why" in band
        else [name, f"{band['half_width']:.3g}", f"{band['inside']:.1%}"]
        for name, band in bands.items()
    ]
    return header, rows


def bands_of(selection: Selection) -> dict[str, dict[str, Any]]:
    """Returns what the band of an ensemble says along the curves kept out of its fit, by name.

    The half width is the mean of that of the torque without noise; what was measured has noise, so
    that it is compared with the band of measured torque. Without a band there is the reason why.
    """
    summaries, found = {}, selection.ensemble
    if found is None:
        return {}
    for curve in selection.fit.curves.held_out():
        try:
            low, high = found.band(curve)
            least, most = found.measured_band(curve)
        except InputError as error:
            summaries[curve.name] = {"why": str(error)}
            continue
        inside = (least <= curve.torque) & (curve.torque <= most)
        summaries[curve.name] = {
            "half_width": float(np.mean(high - low)) / 2,
            "inside": float(np.mean(inside)),
        }
    return summaries


def band_of(fit: Fit) -> dict[str, float] | None:
    """Returns the largest half width [N·m] of the torque's 95 % band along the fitted curves.

    None without a verdict that the model holds beyond them: the band is that of its parameters, and
    says nothing about a model of the wrong kind. Also None where a fit did not minimize squares.
    """
    if fit.verdict != DESCRIBES:
        return None
    try:
        found = fit.uncertainty()
        ends = [found.band(curve) for curve in fit.curves.fitted()]
    except InputError:
        return None
    return {"level": 0.95, "half_width": max(float(np.max(high - low)) / 2 for low, high in ends)}


def uncertainty_table(fit: Fit, found: Uncertainty) -> Rows:
    """Returns one row per parameter: value, standard error and 95 % interval."""
    header = ["parameter", "value", "standard\nerror", "95 % interval"]
    units = _units(fit.model) | {"initial_torque": "N·m"}
    rows = []
    for i, name in enumerate(found.names[:MOST_ROWS]):
        low, high = found.intervals[i]
        base, bracket, number = name.partition("[")
        rows.append(
            [
                labeled(base, units).replace(base, base + bracket + number, 1),
                f"{found.values[i]:.5g}",
                f"{found.standard_errors[i]:.2g}",
                f"{low:.5g} .. {high:.5g}",
            ]
        )
    if len(found.names) > MOST_ROWS:
        rows.append([f"{len(found.names) - MOST_ROWS} more in result.json", "", "", ""])
    return header, rows


def _units(model: HysteresisModel) -> dict[str, str]:
    inner = _units(model.model) if isinstance(model, Wrapper) else {}
    return {**inner, **model.units}


def fit_summary(fit: Fit, seed: int) -> dict[str, Any]:
    """Returns a fit as plain values for JSON."""
    certificate = fit.model.certificate()
    return {
        "method": fit.method,
        "seed": seed,
        "model_name": fit.model_name,
        "model": fit.model.to_dict(),
        "initial_torque": fit.initial_torque,
        "tare": fit.tare,
        "softening": fit.softening and fit.softening._asdict(),
        "fitness": fit.fitness,
        "nrmse": fit.nrmse,
        "prediction_max_error": fit.prediction_errors,
        "evaluations": fit.evaluations,
        "agreed": fit.agreed,
        "starts": fit.starts,
        "trials": len(fit.trials),
        "interrupted": fit.interrupted,
        "remarks": [asdict(remark) for remark in fit.remarks],
        "verdict": fit.verdict,
        "judgement": fit.judgement and fit.judgement.to_dict(),
        "band": band_of(fit),
        "certificate": {**asdict(certificate), "certified": certificate.certified},
    }


def selection_summary(selection: Selection) -> dict[str, Any]:
    """Returns what a selection has beside its fit, as plain values for JSON."""
    members = selection.ensemble
    return {
        "why": selection.why,
        "agreement": selection.agreement and selection.agreement._asdict(),
        "candidates": [_candidate_summary(one) for one in selection.candidates],
        "ensemble": members and {**members.to_dict(), "bands": bands_of(selection)},
    }


def advised(remark: Remark) -> str:
    """Returns a remark with the option of the command line that would act on it."""
    if remark.code == "wandering":
        return f"{remark.sentence} (activesuit identify FIRST.csv SECOND.csv --method auto)"
    if remark.option is None:
        return remark.sentence
    name, value = remark.option
    return f"{remark.sentence} (--{name.replace('_', '-')} {value})"


def _candidate_summary(one: Candidate) -> dict[str, Any]:
    return {
        "name": one.name,
        "parameters": one.parameters,
        "prediction_nrmse": one.prediction_nrmse,
        "fit_nrmse": one.fit_nrmse,
        "failed": one.reason or None,
    }


def uncertainty_summary(found: Uncertainty) -> dict[str, Any]:
    """Returns the uncertainty of the parameters as plain values for JSON."""
    return {
        "names": found.names,
        "values": found.values,
        "standard_errors": found.standard_errors,
        "intervals": found.intervals,
        "condition": found.condition,
        "sloppy": found.sloppy,
        "noise": found.noise.deviation,
        "noise_correlation": found.noise.memory,
        "offset": found.offset and found.offset._asdict(),
        "left_open": found.left_open,
        "offset_open": found.offset_open,
        "samples": [sample.to_dict() for sample in found.samples],
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
            "agreed": trial.agreed,
            "starts": trial.starts,
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
