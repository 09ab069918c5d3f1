"""Fits as tables, as plain values for JSON, and as rows of a CSV file."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..hysteresis.parameter_table import labeled, parameter_table
from ..hysteresis.protocol import HysteresisModel
from ..plots import Plot
from ..tables import Rows
from . import figures
from .corrections.corrections import Corrections
from .fit import Fit
from .fit_curves import NONE
from .fits.parameters import numbers_in
from .judging.coverage import Coverage
from .judging.sentences import DESCRIBES, NOT_BEYOND, SENTENCES, sentence
from .judging.uncertainty import CONFIDENCE, Uncertainty, kind_of
from .selection import Selection

SQUARES = ("auto", "certified")  # methods that minimize squares
MOST_ROWS = 20  # limit of a table on the screen
# Attributes that JSON has as they are.
FIT = (
    *("method", "model_name", "initial_torque", "tare", "fitness", "nrmse", "evaluations"),
    *("agreed", "starts", "interrupted", "verdict"),
)
CANDIDATE = ("name", "parameters", "prediction_nrmse", "fit_nrmse")
UNCERTAIN = (
    *("names", "values", "standard_errors", "intervals", "condition", "open_ends", "left_open"),
    "offset_open",
)
TRIAL = ("nrmse", "evaluations", "agreed", "starts", "initial_torque")


def quality_table(fits: Mapping[str, Mapping[str, Fit]]) -> Rows:
    """Returns one row per curve family and method: errors, certificate, cost and prediction."""
    header = ["curves", "method", "fitness,\neq. (7)", "NRMSE", "margin"]
    header += ["model\nruns", "starts that\nagree", "held-out\nmax [N·m]"]
    return header, [
        [
            joint,
            method,
            f"{fit.fitness:.2e}",
            f"{fit.nrmse:.2%}",
            f"{fit.model.certificate().margin:.3f}",
            "-" if fit.evaluations is None else f"{fit.evaluations:,}",
            "-" if fit.agreed is None else f"{fit.agreed} of {fit.starts}",
            "\n".join(f"{name}: {error:.2f}" for name, error in fit.prediction_errors.items())
            or "-",
        ]
        for joint, methods in fits.items()
        for method, fit in methods.items()
    ]


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
    return header, [
        [name, "none", band["why"]]
        if "why" in band
        else [name, f"{band['half_width']:.3g}", f"{band['inside']:.1%}"]
        for name, band in bands.items()
    ]


def bands_of(selection: Selection) -> dict[str, dict[str, Any]]:
    """Returns the band of an ensemble along the curves kept out of its fit, by name.

    The half width is the mean for the torque without noise. The share inside counts measured
    samples, which have noise, in the band of measured torque. Without a band there is the reason.
    """
    summaries: dict[str, dict[str, Any]] = {}
    if (found := selection.ensemble) is None:
        return summaries
    for curve in selection.fit.curves.held_out():
        try:
            low, high = found.band(curve)
            least, most = found.measured_band(curve)
        except InputError as error:
            summaries[curve.name] = {"why": str(error)}
            continue
        inside = (least <= curve.torque) & (curve.torque <= most)
        half_width = float(np.mean(high - low)) / 2
        summaries[curve.name] = {"half_width": half_width, "inside": float(np.mean(inside))}
    return summaries


def band_of(fit: Fit) -> dict[str, float] | None:
    """Returns the largest half width [N·m] of the torque's 95 % band along the fitted curves.

    The band follows from the parameters alone and assumes the right kind of model: it is None
    unless the verdict is that the model holds, also beyond the curves, and None for fits that did
    not minimize squares.
    """
    if fit.verdict != DESCRIBES:
        return None
    try:
        found = fit.uncertainty()
        ends = [found.band(curve) for curve in fit.curves.fitted()]
    except InputError:
        return None
    half_width = max(float(np.max(high - low)) / 2 for low, high in ends)
    return {"level": CONFIDENCE, "half_width": half_width}


def uncertainty_table(fit: Fit, found: Uncertainty) -> Rows:
    """Returns one row per parameter: value, standard error and 95 % interval."""
    header = ["parameter", "value", "standard\nerror", "95 % interval"]
    units = {one.name: one.unit for one in fit.parameters if one.unit} | {"initial_torque": "N·m"}
    rows = []
    for i, name in enumerate(found.names):
        low, high = found.intervals[i]
        value, error = f"{found.values[i]:.5g}", f"{found.standard_errors[i]:.2g}"
        rows.append([labeled(name, units), value, error, f"{low:.5g} .. {high:.5g}"])
    known = [one for one in fit.parameters if one.state != "free"]
    rows += [[labeled(one.name, units), f"{one.value:.5g}", "", one.state] for one in known]
    if len(rows) > MOST_ROWS:
        rows[MOST_ROWS:] = [[f"{len(rows) - MOST_ROWS} more in result.json", "", "", ""]]
    return header, rows


def fit_summary(fit: Fit, seed: int) -> dict[str, Any]:
    """Returns a fit as plain values for JSON."""
    certificate = fit.model.certificate()
    return {
        **_plain(fit, FIT),
        "seed": seed,
        "model": fit.model.to_dict(),
        "softening": fit.softening and fit.softening._asdict(),
        "constraints": asdict(fit.constraints),
        "prediction_max_error": fit.prediction_errors,
        "trials": len(fit.trials),
        "remarks": [remark.to_dict() for remark in fit.remarks],
        "judgement": fit.judgement and fit.judgement.to_dict(),
        "band": band_of(fit),
        "certificate": {**asdict(certificate), "certified": certificate.certified},
    }


def _plain(one: Any, names: Sequence[str]) -> dict[str, Any]:
    """Returns attributes by name."""
    return {name: getattr(one, name) for name in names}


def trial_columns(fits: Mapping[str, Mapping[str, Fit]]) -> tuple[list[str], list[list[Any]]]:
    """Returns a row per trial of every fit, angles of Jiles-Atherton in degrees."""
    rows = [
        {
            "curves": curves,
            "method": method,
            "trial": trial.index,
            **_plain(trial, TRIAL),
            **{name: one for _, name, one in numbers_in((), "", trial.model.to_dict())},
        }
        for curves, methods in fits.items()
        for method, fit in methods.items()
        for trial in fit.trials
    ]
    header = list(dict.fromkeys(name for row in rows for name in row))
    return header, [[row.get(column) for column in header] for row in rows]


@dataclass(frozen=True, kw_only=True)
class Identification:
    """Result of `identify`: a judged model, with its tables, sentences, columns and figures.

    Attributes:
        result: The fit, or the selection of a kind of model with its fit.
        seed: Seed of the fit.
        uncertainty: Uncertainty of the parameters; None without samples.
        corrections: Requested corrections of the curves.
        use: Name of the use of the model; None if none was given.
        needed: Coverage of curves that this use needs; None without a use.
        notes: Sentences on averaged cycles and on the choice of the method.
    """

    result: Fit | Selection
    seed: int = 0
    uncertainty: Uncertainty | None = None
    corrections: Corrections = NONE
    use: str | None = None
    needed: Coverage | None = None
    notes: tuple[str, ...] = ()

    def __str__(self) -> str:
        return "\n".join(self.sentences())

    def __getattr__(self, name: str) -> Any:
        if name in Fit.__dataclass_fields__ or hasattr(Fit, name):
            raise AttributeError(f"an identification has no {name}: write identify(...).fit.{name}")
        raise AttributeError(f"an identification has no attribute {name!r}")

    @property
    def selection(self) -> Selection | None:
        """The selection of a kind of model; None where the kind was given."""
        return self.result if isinstance(self.result, Selection) else None

    @property
    def fit(self) -> Fit:
        """The fit, with its errors."""
        return self.result.fit if isinstance(self.result, Selection) else self.result

    @property
    def model(self) -> HysteresisModel:
        """The model."""
        return self.fit.model

    @property
    def verdict(self) -> str:
        """Whether the model describes the curves, as a phrase."""
        return self.fit.verdict

    @property
    def description(self) -> str:
        """Source, method and seed, in a sentence."""
        fit = self.fit
        text = f"Identified from {fit.curves.source} by {fit.method}, seed {self.seed}"
        kept = f", interrupted: the best of the {self.finished}" if fit.interrupted else ""
        return f"{text}{kept}."

    @property
    def finished(self) -> str:
        """How many models or trials are finished, in words."""
        if self.selection:
            return f"{len(self.selection.candidates)} models tried so far"
        return f"{len(self.fit.trials)} finished trials"

    @property
    def left_open(self) -> list[str]:
        """Effects that the curves leave open and that no sample has, as phrases."""
        kinds = [] if self.selection else ["left open kinds"]
        if (kind := f"left open {self.verdict}") in SENTENCES:
            kinds.append(kind)
        found = self.uncertainty.left_open if self.uncertainty else ()
        return [*found, *map(sentence, kinds)]

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        fit = self.fit
        coverage = {
            "for": self.use,
            "measured": fit.coverage and asdict(fit.coverage),
            "needed": self.needed and asdict(self.needed),
            "shortfalls": [one.sentence for one in fit.shortfalls],
        }
        summary = {**fit_summary(fit, self.seed), "coverage": coverage}
        summary["reading"] = fit.curves.reading
        if (chosen := self.selection) is not None:
            members, alike = chosen.ensemble, chosen.agreement
            summary["why"] = chosen.why
            summary["agreement"] = alike and _plain(alike, ("half_width", "tested", "sentence"))
            summary["candidates"] = [
                {**_plain(one, CANDIDATE), "failed": one.reason or None}
                for one in chosen.candidates
            ]
            summary["ensemble"] = members and {**members.to_dict(), "bands": bands_of(chosen)}
        if (found := self.uncertainty) is not None:
            summary["uncertainty"] = {
                **_plain(found, UNCERTAIN),
                "noise": found.noise.deviation,
                "noise_correlation": found.noise.memory,
                "offset": found.offset and found.offset._asdict(),
                "samples": [sample.to_dict() for sample in found.samples],
            }
        return summary

    def tables(self) -> dict[str, Rows]:
        """Returns tables by title; the first one compares the candidates of a selection."""
        fit, found, tables = self.fit, self.uncertainty, {}
        name = fit.curves.source
        if self.selection:
            tables[f"models for {name}"] = candidate_table(self.selection)
        header, rows = parameter_table({"value": fit.model})
        start = fit.initial_torque
        begins = start if isinstance(start, str) else f"{start:.5g}"
        rows = [*rows, ["initial torque [N·m]", begins]]
        for state in ("fixed", "at its bound"):
            names = [one.name for one in fit.parameters if one.state == state]
            shown = names[:MOST_ROWS] + (["..."] if len(names) > MOST_ROWS else [])
            rows += [[state, "\n".join(shown)]] if names else []
        if fit.tare:
            sure = ""
            if found and found.offset:
                low, high = found.offset.interval(fit.tare)
                sure = f" ({low:.3g} to {high:.3g})"
            rows.append(["tare [N·m]", f"{fit.tare:.5g}{sure}"])
        if fit.softening:
            first, steady, cycles, _ = fit.softening
            change = f"{first:.3f} first, {steady:.3f} steady, 1/e in {cycles:.3g} cycles"
            rows.append(["torque over the last", change])
        tables[name] = header, rows
        tables["quality"] = quality_table({Path(name).stem: {fit.method: fit}})
        if self.selection and (bands := bands_of(self.selection)):
            tables["bands of nominal 90 % over kinds of model"] = band_table(bands)
        if found:
            tables["how sure the parameters are"] = uncertainty_table(fit, found)
        return tables

    def sentences(self) -> list[str]:
        """Returns all sentences of the result, the most important first."""
        fit, found, said = self.fit, self.uncertainty, [*self.notes]
        for one in fit.remarks:
            if one.code == "open":
                said.append(f"tare: {one.sentence} (--tare NUMBER)")
        said.append(self._verdict())
        if self.selection:
            said.append(self.selection.why)
            if self.selection.agreement:
                said.append(f"agreement: {self.selection.agreement.sentence}")
        if fit.judgement:
            noise = fit.judgement.noise
            kind = "noise uneven" if noise.share else "noise"
            said.append(sentence(kind, constant=noise.constant, percent=100 * noise.share))
        if band := band_of(fit):
            values = band | {"share": band["half_width"] / fit.curves.peak}
            kinds = "" if self.selection else " (--method auto compares kinds)"
            said.append(sentence("band", **values, kinds=kinds))
        elif fit.verdict == NOT_BEYOND:
            said.append(sentence("band none"))
        notes = [*self._open_offset(), *(one.advice for one in fit.remarks if one.code != "open")]
        for end, names in (found.open_ends if found else {}).items():
            notes.append(sentence("open ends", end=end, names=", ".join(names)))
        said += [f"note: {one}" for one in notes]
        if found:
            kinds = len({kind_of(one) for one in found.samples})
            values = {"count": len(found.samples), "kinds": f"{kinds} kind{'s' * (kinds != 1)}"}
            without = "; ".join(self.left_open) or "nothing that is known"
            said.append(sentence("samples", **values, without=without))
        return said

    def columns(self, joint: str) -> dict[str, tuple[Sequence[str], Iterable[Sequence[Any]]]]:
        """Returns columns of CSV files by name: all trials, and the loops with their model."""
        return {
            "trials.csv": trial_columns({joint: {self.fit.method: self.fit}}),
            "loops.csv": (figures.COLUMNS, figures.loop_rows(joint, self._compared())),
        }

    def plots(self, joint: str) -> dict[str, Plot]:
        """Returns figures by name: the loops, and their difference from the model."""
        fit = self.fit
        return {"loops": figures.loops_plot(joint, {fit.model_name: self._compared()}, fit.tare)}

    def _compared(self) -> list[figures.Compared]:
        return figures.compared(self.fit.curves, self.result, self.uncertainty)

    def _verdict(self) -> str:
        """Returns the verdict; without an intended motion, also which loops and rates lack."""
        fit = self.fit
        if self.use or fit.verdict != NOT_BEYOND or fit.coverage is None:
            return sentence("verdict", verdict=fit.verdict)
        found, rates = fit.coverage, sentence("rates none")
        if found.rates:
            rates = sentence("rates", slowest=found.rates[0], fastest=found.rates[1])
        values = {"nesting": found.nesting, "shortest": found.branches[0], "rates": rates}
        return sentence("verdict beyond", verdict=fit.verdict, **values)

    def _open_offset(self) -> Iterator[str]:
        """Yields a sentence if no tare is given and the curves do not determine it."""
        fit = self.fit
        squares = fit.method in SQUARES and fit.judgement is not None
        if self.corrections.tare != 0 or not squares:
            return
        kinds = (self.uncertainty or self.result.uncertainty()).offset_open
        if kinds:
            yield sentence("offset open", kinds=", ".join(kinds))
