"""Fits as tables, as plain values for JSON, and as rows of a CSV file."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..hysteresis.around import Wrapper
from ..hysteresis.parameter_table import labeled, parameter_table
from ..hysteresis.protocol import HysteresisModel
from ..plots import Plot
from ..tables import Rows
from . import figures
from .corrections.corrections import Corrections
from .fit import Fit
from .fit_curves import NONE
from .judging.coverage import Coverage
from .judging.remarks import Remark
from .judging.uncertainty import Uncertainty, kind_of
from .judging.verdict import DESCRIBES, NOT, NOT_BEYOND, UNKNOWN
from .selection import Selection

TARE = "--tare NUMBER"
SQUARES = ("auto", "certified")  # methods that minimize squares
MISSING = {  # by verdict: what no sample of the model has
    NOT: "what the model does not describe in its own curves",
    UNKNOWN: "whether the kind of model is right",
    NOT_BEYOND: "motions unlike the curves",
}
MOST_ROWS = 20  # limit of a table on the screen
# Attributes that JSON has as they are.
CANDIDATE = ("name", "parameters", "prediction_nrmse", "fit_nrmse")
UNCERTAIN = ("names", "values", "standard_errors", "intervals", "condition", "sloppy")
TRIAL = ("nrmse", "evaluations", "agreed", "starts", "initial_torque")


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
    known = [one for one in fit.parameters if one.state != "free"]
    sure = zip(found.names, found.values, found.standard_errors, found.intervals, strict=True)
    rows = [
        [_labeled(name, units), f"{value:.5g}", f"{error:.2g}", f"{low:.5g} .. {high:.5g}"]
        for name, value, error, (low, high) in sure
    ]
    rows += [[_labeled(one.name, units), f"{one.value:.5g}", "", one.state] for one in known]
    more = len(rows) - MOST_ROWS
    if more > 0:
        rows[MOST_ROWS:] = [[f"{more} more in result.json", "", "", ""]]
    return header, rows


def _labeled(name: str, units: Mapping[str, str]) -> str:
    """Returns the name of a number with its unit, that of one in a list with its index."""
    base, bracket, index = name.partition("[")
    return labeled(base, units).replace(base, base + bracket + index, 1)


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
        "constraints": asdict(fit.constraints),
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
        "candidates": [
            {**_plain(one, CANDIDATE), "failed": one.reason or None} for one in selection.candidates
        ],
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


def _plain(one: Any, names: Sequence[str]) -> dict[str, Any]:
    """Returns attributes by name."""
    return {name: getattr(one, name) for name in names}


def uncertainty_summary(found: Uncertainty) -> dict[str, Any]:
    """Returns the uncertainty of the parameters as plain values for JSON."""
    return {
        **_plain(found, UNCERTAIN),
        "noise": found.noise.deviation,
        "noise_correlation": found.noise.memory,
        "offset": found.offset and found.offset._asdict(),
        **_plain(found, ("left_open", "offset_open")),
        "samples": [sample.to_dict() for sample in found.samples],
    }


def trial_columns(fits: Mapping[str, Mapping[str, Fit]]) -> tuple[list[str], list[list[Any]]]:
    """Returns a row per trial of every fit, angles of Jiles-Atherton in degrees."""
    rows = [
        {
            "curves": curves,
            "method": method,
            "trial": trial.index,
            **_plain(trial, TRIAL),
            **dict(_numbers("", trial.model.to_dict())),
        }
        for curves, methods in fits.items()
        for method, fit in methods.items()
        for trial in fit.trials
    ]
    header = list(dict.fromkeys(name for row in rows for name in row))
    return header, [[row.get(column) for column in header] for row in rows]


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


@dataclass(frozen=True, kw_only=True)
class Identification:
    """Result of `identify`: a judged model, with its tables, sentences, columns and figures.

    Attributes:
        result: The fit, or the selection of a kind of model with its fit.
        seed: Seed of the fit.
        uncertainty: Uncertainty of the parameters; None if it was not asked for.
        corrections: Corrections of the curves that were asked for.
        use: What the model is for; None if that was not said.
        needed: What this use needs of curves; None likewise.
        notes: What was done to the curves, and why the method is this one, as sentences.
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
        return (
            f"{text}, interrupted: the best of the {self.finished}."
            if fit.interrupted
            else f"{text}."
        )

    @property
    def finished(self) -> str:
        """How many models or trials are finished, in words."""
        if isinstance(self.result, Selection):
            return f"{len(self.result.candidates)} models tried so far"
        return f"{len(self.result.trials)} finished trials"

    @property
    def left_open(self) -> list[str]:
        """What the curves leave open and no sample has, as phrases."""
        fit, found = self.fit, self.uncertainty
        return [
            *(found.left_open if found else ()),
            *([] if isinstance(self.result, Selection) else ["other kinds of model"]),
            *([MISSING[fit.verdict]] if fit.verdict in MISSING else ()),
        ]

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        fit = self.fit
        coverage = {
            "for": self.use,
            "measured": fit.coverage and fit.coverage.to_dict(),
            "needed": self.needed and self.needed.to_dict(),
            "shortfalls": fit.shortfalls,
        }
        summary = {**fit_summary(fit, self.seed), "coverage": coverage}
        summary["reading"] = fit.curves.reading
        if isinstance(self.result, Selection):
            summary |= selection_summary(self.result)
        if self.uncertainty:
            summary["uncertainty"] = uncertainty_summary(self.uncertainty)
        return summary

    def tables(self) -> dict[str, Rows]:
        """Returns tables by title, beginning with that of the models it was chosen from."""
        fit, found, tables = self.fit, self.uncertainty, {}
        name = fit.curves.source
        if isinstance(self.result, Selection):
            tables[f"models for {name}"] = candidate_table(self.result)
        header, rows = parameter_table({"value": fit.model})
        start = fit.initial_torque
        begins = start if isinstance(start, str) else f"{start:.5g}"
        rows = [*rows, ["initial torque [N·m]", begins]]
        for state in ("fixed", "at its bound"):
            names = [one.name for one in fit.parameters if one.state == state]
            shown = names[:MOST_ROWS] + (["..."] if len(names) > MOST_ROWS else [])
            rows += [[state, "\n".join(shown)]] if names else []
        if fit.tare:
            rows.append(["tare [N·m]", f"{fit.tare:.5g}{self._deviation()}"])
        if fit.softening:
            first, steady, cycles, _ = fit.softening
            change = f"{first:.3f} first, {steady:.3f} steady, 1/e in {cycles:.3g} cycles"
            rows.append(["torque over the last", change])
        tables[name] = header, rows
        tables["quality"] = quality_table({Path(name).stem: {fit.method: fit}})
        if isinstance(self.result, Selection) and (bands := bands_of(self.result)):
            tables["bands of nominal 90 % over kinds of model"] = band_table(bands)
        if found:
            tables["how sure the parameters are"] = uncertainty_table(fit, found)
        return tables

    def sentences(self) -> list[str]:
        """Returns the verdict, and what else there is to say, the most important first."""
        fit, found = self.fit, self.uncertainty
        said = [*self.notes]
        said += [f"tare: {one.sentence} ({TARE})" for one in fit.remarks if one.code == "open"]
        said += [f"verdict: the model {fit.verdict}{self._not_contained()}"]
        if isinstance(self.result, Selection):
            said.append(self.result.why)
            if self.result.agreement:
                said.append(f"agreement: {self.result.agreement.sentence}")
        if fit.judgement:
            said.append(f"noise: {fit.judgement.noise}")
        said += self._band()
        notes = [advised(one) for one in fit.remarks if one.code != "open"]
        notes += found.sloppy if found else ()
        said += [f"note: {one}" for one in (*self._open_offset(), *notes)]
        if found:
            kinds = len({kind_of(one) for one in found.samples})
            of = "1 kind" if kinds == 1 else f"{kinds} kinds"
            without = "; ".join(self.left_open) or "nothing that is known"
            said.append(
                f"samples: {len(found.samples)}, of {of} of model, which the curves allow too; not "
                f"among them: {without}"
            )
        return said

    def columns(self, joint: str) -> dict[str, tuple[Sequence[str], Iterable[Sequence[Any]]]]:
        """Returns columns of CSV files by name: every trial, and the loops with their model."""
        return {
            "trials.csv": trial_columns({joint: {self.fit.method: self.fit}}),
            "loops.csv": (figures.COLUMNS, figures.loop_rows(joint, self._compared())),
        }

    def plots(self, joint: str) -> dict[str, Plot]:
        """Returns figures by name: the loops, with what the model leaves of them."""
        fit = self.fit
        return {"loops": figures.loops_plot(joint, {fit.model_name: self._compared()}, fit.tare)}

    def _compared(self) -> list[figures.Compared]:
        return figures.compared(self.fit.curves, self.result, self.uncertainty)

    def _band(self) -> Iterator[str]:
        """Yields how far the torque may be from the model, or why nobody can say."""
        fit, band = self.fit, band_of(self.fit)
        if band:
            half = band["half_width"]
            kinds = "" if isinstance(self.result, Selection) else " (--method auto compares kinds)"
            yield (
                f"band: along these curves the torque is within {half:.2g} N·m of the model "
                f"({half / fit.curves.peak:.1%} of the peak), at {band['level']:.0%}, if its kind "
                f"is right{kinds}"
            )
        elif fit.verdict == NOT_BEYOND:
            yield (
                "band: none, because nothing tests the model beyond these curves; measure also the "
                "record of activesuit design"
            )

    def _open_offset(self) -> Iterator[str]:
        """Yields that the curves do not determine the sensor's offset, where none is given."""
        fit = self.fit
        squares = fit.method in SQUARES and fit.judgement is not None
        if self.corrections.tare != 0 or not squares:
            return
        kinds = (self.uncertainty or self.result.uncertainty()).offset_open
        if kinds:
            yield (
                "these curves do not determine the offset of the torque sensor (any, by "
                f"{', '.join(kinds)}): if the sensor was not zeroed, its offset is in the model; "
                f"zero the sensor, or give its offset ({TARE})"
            )

    def _deviation(self) -> str:
        """Returns how sure a tare is, where that is known."""
        if self.uncertainty is None or self.uncertainty.offset is None:
            return ""
        low, high = self.uncertainty.offset.interval(self.fit.tare)
        return f" ({low:.3g} to {high:.3g})"

    def _not_contained(self) -> str:
        """Returns what curves do not contain whose model is not valid beyond them, as a phrase."""
        fit = self.fit
        if self.use or fit.verdict != NOT_BEYOND or fit.coverage is None:
            return ""
        found = fit.coverage
        rates = "no times"
        if found.rates:
            rates = f"no rates but {found.rates[0]:.2g} to {found.rates[1]:.2g} rad/s"
        return (
            f": they have no loops inside loops (reversals nested {found.nesting} deep), no branch "
            f"below {found.branches[0]:.0%} of the range, {rates}; and no intended motion is named "
            "(--for)"
        )
