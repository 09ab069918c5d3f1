"""`activesuit identify`: fits a hysteresis model to a file of measured curves."""

from collections.abc import Iterator
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, get_args

import tyro

from ...assets import Suit, load_suit
from ...checks import at_least
from ...errors import InputError, shown
from ...identification import Corrections, Coverage, Curves, Fit, Selection, load_curves, select
from ...identification import identify as identify_curves
from ...identification.corrections import averaged
from ...identification.cycles import cycles_of
from ...identification.figures import loops_figure
from ...identification.fits.registry import FITS
from ...identification.identify import NONE
from ...identification.left_out import questions
from ...identification.methods import DEFAULT_MODEL, Magnetic, method_names, method_of
from ...identification.objective import InitialTorque, Loss, Normalize
from ...identification.residual.verdict import NOT, NOT_BEYOND, UNKNOWN
from ...identification.uncertainty.uncertainty import Uncertainty, kind_of
from ..curve_joints import joint_of
from ..html.loops import loop_rows, write_loops
from ..html.writing import write_report
from ..intended import intended_motions, needed_coverage
from ..options import Force, Json, Seed, Use, choice, joints, named_values, optional_number, suits
from ..output import Rows, RunFolder, progress, say, table, to_json
from ..reports.fits import (
    advised,
    band_table,
    bands_of,
    candidate_table,
    fit_summary,
    quality_table,
    selection_summary,
    uncertainty_summary,
    uncertainty_table,
    write_trials,
)
from ..reports.parameters import parameter_table

Titled = tuple[str, Rows, int]  # title, table, and how many of its columns are aligned left

NOT_DESCRIBED = 3  # exit code; also where the tare that was to be fitted is not determined
TARE = "--tare NUMBER"
AUTO, CERTIFIED = "auto", "certified"  # methods; of auto `select` chooses the model
MISSING = {  # by verdict: what no sample of the model has
    NOT: "what the model does not describe in its own curves",
    UNKNOWN: "whether the kind of model is right",
    NOT_BEYOND: "motions unlike the curves",
}
SAMPLES = 20  # further models in a suit file
_METHOD = (
    "Method of the fit: certified finds a model that is safe to simulate; auto finds the simplest "
    "of all models that predicts curves left out of its fit; magnetic finds the form of "
    "Jiles-Atherton for magnetization over a field; the others are the papers' swarms and "
    "optimizers of extensions."
)


def identify(
    curves: Annotated[tuple[Path, ...], tyro.conf.Positional],
    /,
    columns: tuple[str, ...] = (),
    units: tuple[str, ...] = (),
    decimal: Annotated[
        str | None, choice(lambda: (".", ","), usual="what the numbers show")
    ] = None,
    model: Annotated[str | None, choice(lambda: FITS)] = None,
    method: Annotated[
        str | None,
        choice(
            lambda: [*method_names(), AUTO],
            _METHOD,
            "auto for one long record, otherwise certified",
        ),
    ] = None,
    objective: Annotated[Loss | None, choice(lambda: get_args(Loss))] = None,
    normalize: Annotated[Normalize | None, choice(lambda: get_args(Normalize))] = None,
    initial_torque: InitialTorque | None = None,
    corrections: Annotated[Corrections, tyro.conf.arg(name="")] = NONE,
    trials: int | None = None,
    seed: Seed = 0,
    workers: int = -1,
    samples: Annotated[
        int | None, optional_number(f"{SAMPLES} with --out, otherwise 0", int)
    ] = None,
    use: Use = None,
    joint: Annotated[str | None, choice(joints)] = None,
    base: Annotated[str | None, choice(suits)] = None,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Identify a hysteresis model from measured angle-torque curves.

    Curves with role "predict" are kept out of the fit and used to test it. The verdict says whether
    the model describes the curves; if it does not, or if the curves do not determine the tare that
    was to be fitted, all is written and the exit code is 3.

    Args:
        curves: Files of curves: CSV with the columns curve, angle_rad (or angle_deg), torque_nm,
            and optionally role (fit or predict), weight, and time_s; or tables of a rig, whose
            separator, decimal mark, columns and units are found where the header names them.
        columns: Names in the header, or numbers from 1 on, of columns that are not found, as
            angle="Winkel 1 [Grad]" torque=3: angle, torque, time, curve, role, weight.
        units: Units that the header does not name, as angle=deg torque="0.5 Nm/V" time=ms.
        decimal: Decimal mark of the numbers, where they leave it open: . or ,
        model: Hysteresis model to fit, jiles-atherton by default; asymmetric is the same beside a
            polynomial. The method certified has all models, the other methods only jiles-atherton.
        objective: Quantity that a swarm or optimizer minimizes: nrmse (by default), paper (eq. 7
            of Li et al. 2022), sse, or robust (against outliers).
        normalize: Torque that divides the errors of the objective: the largest one of the family
            (by default) or of each curve.
        initial_torque: Torque with which each curve begins: a number in N·m (by default 0),
            measured (the first sample of the curve) or identified (one number for all curves).
            Only jiles-atherton has this choice; the fits of other models identify it.
        trials: Number of independent runs, of which the best counts; by default 1 for certified
            and 30 for swarms and optimizers.
        workers: Number of threads; -1 uses all cores.
        samples: Number of further models in suit.json that the curves allow too, for `validate` and
            to randomize the simulation with; the uncertainty of the parameters is shown as well.
            They have other noise, and where the curves limit them, another offset of the sensor
            and another damping; a line below the verdict says what they lack. With the method auto
            they are of all models that predict nearly as well as the best.
        joint: Joint on which the curves were measured; by default the file name tells it
            (elbow.csv).
        base: Suit whose other joints suit.json takes over; by default it has this joint only.
        out: Folder for suit.json, result.json, trials.csv, report.html and the loops as PNG and
            SVG: a new or an empty one.
    """
    if not curves:
        raise InputError("there is no file of curves: give at least one")
    family = load_curves(
        *curves,
        columns=named_values("--columns", columns),
        units=named_values("--units", units),
        decimal=decimal,
    )
    for sentence in [] if json else family.reading:
        say(f"read {sentence}")
    family, corrections = _averaged(family, corrections, quiet=json)
    if base is not None and not out:
        raise InputError(f"--base {base} needs --out: its joints go into suit.json there")
    if out and method == Magnetic.name:
        raise InputError(
            f"out is {shown(str(out))}: a suit file has joints, which a model of magnetics drives; "
            "leave it out, and take the result from --json"
        )
    samples = (SAMPLES if out else 0) if samples is None else samples
    at_least("samples", samples, 0)
    joint_name = joint_of(curves[0], joint) if out or joint is not None else None
    motions = intended_motions(curves[0], use, joint)
    needed = needed_coverage(family, use, motions)
    others = None if base is None else load_suit(base)
    folder = RunFolder(out, force=force) if out else None
    beside = {"model": model, "objective": objective, "normalize": normalize, "trials": trials}
    method = method or _usual_method(family, **beside, quiet=json)
    if method == AUTO:
        _refuse_beside_auto(**beside)
        run = partial(
            select, family, intended=motions, on_candidate=lambda candidate: bar.advance()
        )
        total = len(FITS) * (2 if corrections.tare == "fit" else 1)  # again without it, if open
    else:
        chosen = method_of(method, trials=trials, objective=objective, normalize=normalize)
        run = partial(
            *(identify_curves, family),
            model=model or DEFAULT_MODEL,
            method=chosen,
            on_trial=lambda trial: bar.advance(),
        )
        total = chosen.trials
    with progress(f"{method} on {family.source}", total) as bar:
        result = run(
            corrections=corrections,
            initial_torque=initial_torque,
            seed=seed,
            workers=workers,
            needed=needed,
        )
    found = result.uncertainty(samples=samples, seed=seed) if samples else None
    summary = _summary(result, seed, use, needed, found)
    tables = _tables(result, found)
    sentences = _sentences(result, corrections, use, found, summary["band"])
    sentences += _about_suit(_fit(result), joint_name if out and base is None else None, found)
    if json:
        print(to_json(summary))
    else:
        _print(result, tables, sentences)
    if folder and joint_name:
        description = _description(result, seed)
        suit = _suit(_fit(result), joint_name, curves[0].stem, description, others, found)
        given = {
            **{"curves": curves, "method": method, **beside, "initial_torque": initial_torque},
            **{"corrections": asdict(corrections), "samples": samples, "seed": seed},
            **{"for": use, "joint": joint_name, "base": base, "data_sha256": family.sha256},
        }
        suit.save(folder / "suit.json")
        _write(folder, joint_name, _fit(result), summary)
        write_loops(folder, loop_rows(joint_name, result, found))
        write_report(
            *(folder, "identify", f"{family.source}, {joint_name.replace('_', ' ')}"),
            answer=[*sentences, *_why(result)],
            tables={title: rows for title, rows, _ in tables},
            settings=given,
        )
        if not json:
            say(f"wrote {folder.path}/suit.json, result.json, trials.csv, report.html, loops.png")
    _end(result)


def _averaged(family: Curves, corrections: Corrections, quiet: bool) -> tuple[Curves, Corrections]:
    """Returns curves with averaged cycles where that is asked for, and the other corrections."""
    if not corrections.average_cycles:
        return family, corrections
    counts = ", ".join(f"{cycles_of(one)} of {one.name}" for one in family)
    family = averaged(family, corrections)
    if not quiet:
        say(f"mean of the cycles after the first: {counts}")
    return family, replace(corrections, average_cycles=False)


def _usual_method(family: Curves, quiet: bool, **beside: str | int | None) -> str:
    """Returns the method where none is given: auto for a record that it can divide."""
    if len(family.fitted()) != 1 or any(value is not None for value in beside.values()):
        return CERTIFIED
    try:
        questions(family.fitted())
    except InputError:  # too few reversals
        return CERTIFIED
    if not quiet:
        say("method auto, since this is one record of several cycles")
    return AUTO


def _refuse_beside_auto(**given: str | int | None) -> None:
    """Refuses options that mean nothing where the model is selected."""
    why = {
        "model": "method 'auto' chooses the model",
        "objective": "method 'auto' always minimizes the NRMSE over the family",
        "normalize": "method 'auto' always minimizes the NRMSE over the family",
        "trials": "method 'auto' chooses once",
    }
    for name, value in given.items():
        if value is not None:
            raise InputError(f"{name} is {value!r}: {why[name]}; leave one of them out")


def _summary(
    result: Fit | Selection,
    seed: int,
    use: str | None,
    needed: Coverage | None,
    found: Uncertainty | None,
) -> dict[str, Any]:
    """Returns what result.json and --json hold."""
    fit = _fit(result)
    coverage = {
        "for": use,
        "measured": fit.coverage and fit.coverage.to_dict(),
        "needed": needed and needed.to_dict(),
        "shortfalls": fit.shortfalls,
    }
    summary = {**fit_summary(fit, seed), "coverage": coverage, "reading": fit.curves.reading}
    if isinstance(result, Selection):
        summary |= selection_summary(result)
    return {**summary, "uncertainty": uncertainty_summary(found)} if found else summary


def _print(result: Fit | Selection, tables: list[Titled], sentences: list[str]) -> None:
    why = list(_why(result))
    for i, (title, (header, rows), left) in enumerate(tables):
        table(title, header, rows, left=left)
        if i == 0 and why:
            say(f"{why[0]}\n")
    for sentence in sentences:
        say(sentence)


def _why(result: Fit | Selection) -> Iterator[str]:
    """Yields why a model was chosen, if it was."""
    if isinstance(result, Selection):
        yield result.why


def _tables(result: Fit | Selection, found: Uncertainty | None) -> list[Titled]:
    """Returns the tables of a fit, beginning with that of the models it was chosen from."""
    fit = _fit(result)
    name = fit.curves.source
    tables: list[Titled] = []
    if isinstance(result, Selection):
        tables.append((f"models for {name}", candidate_table(result), 1))
    header, rows = parameter_table({"value": fit.model})
    start = fit.initial_torque
    begins = start if isinstance(start, str) else f"{start:.5g}"
    rows = [*rows, ["initial torque [N·m]", begins]]
    if fit.tare:
        rows.append(["tare [N·m]", f"{fit.tare:.5g}{_deviation(fit, found)}"])
    if fit.softening:
        first, steady, cycles, _ = fit.softening
        change = f"{first:.3f} first, {steady:.3f} steady, 1/e in {cycles:.3g} cycles"
        rows.append(["torque over the last", change])
    tables.append((name, (header, rows), 1))
    tables.append(("quality", quality_table({Path(name).stem: {fit.method: fit}}), 2))
    if isinstance(result, Selection) and (bands := bands_of(result)):
        tables.append(("bands of nominal 90 % over kinds of model", band_table(bands), 2))
    if found:
        tables.append(("how sure the parameters are", uncertainty_table(fit, found), 1))
    return tables


def _sentences(
    result: Fit | Selection,
    corrections: Corrections,
    use: str | None,
    found: Uncertainty | None,
    band: dict[str, float] | None,
) -> list[str]:
    """Returns the verdict, and what else there is to say."""
    fit = _fit(result)
    said = [f"tare: {one.sentence} ({TARE})" for one in fit.remarks if one.code == "open"]
    said += [f"verdict: the model {fit.verdict}{_not_contained(fit) if not use else ''}"]
    if isinstance(result, Selection) and result.agreement:
        said.append(f"agreement: {result.agreement.sentence}")
    if fit.judgement:
        said.append(f"noise: {fit.judgement.noise}")
    if band:
        half = band["half_width"]
        said.append(
            f"band: along these curves the torque is within {half:.2g} N·m of the model "
            f"({half / fit.curves.peak:.1%} of the peak), at {band['level']:.0%}, if its kind is "
            f"right{'' if isinstance(result, Selection) else ' (--method auto compares kinds)'}"
        )
    elif fit.verdict == NOT_BEYOND:
        said.append(
            "band: none, because nothing tests the model beyond these curves; measure also the "
            "record of activesuit design"
        )
    notes = [advised(one) for one in fit.remarks if one.code != "open"]
    notes += found.sloppy if found else ()
    return [*said, *(f"note: {one}" for one in (*_open_offset(result, corrections, found), *notes))]


def _open_offset(
    result: Fit | Selection, corrections: Corrections, found: Uncertainty | None
) -> Iterator[str]:
    """Yields that the curves do not determine the sensor's offset, where none is given."""
    fit = _fit(result)
    squares = fit.method in (AUTO, CERTIFIED) and fit.judgement is not None
    if corrections.tare != 0 or not squares:
        return
    kinds = (found or result.uncertainty()).offset_open
    if kinds:
        yield (
            "these curves do not determine the offset of the torque sensor (any, by "
            f"{', '.join(kinds)}): if the sensor was not zeroed, its offset is in the model; zero "
            f"the sensor, or give its offset ({TARE})"
        )


def _about_suit(fit: Fit, alone: str | None, found: Uncertainty | None) -> Iterator[str]:
    """Yields which joint the suit file has, if it has one only, and what the samples contain."""
    if alone is not None:
        name = alone.replace("_", " ")
        yield f"suit: it resists {name} only; --base mock-suit adds the other joints"
    if found:
        kinds = len({kind_of(one) for one in found.samples})
        of = "1 kind" if kinds == 1 else f"{kinds} kinds"
        without = "; ".join(_left_open(fit, found)) or "nothing that is known"
        yield (
            f"samples: {len(found.samples)}, of {of} of model, which the curves allow too; not "
            f"among them: {without}"
        )


def _deviation(fit: Fit, found: Uncertainty | None) -> str:
    """Returns how sure a tare is, where that is known."""
    if found is None or found.offset is None:
        return ""
    low, high = found.offset.interval(fit.tare)
    return f" ({low:.3g} to {high:.3g})"


def _not_contained(fit: Fit) -> str:
    """Returns what curves do not contain whose model is not valid beyond them, as a phrase."""
    if fit.verdict != NOT_BEYOND or fit.coverage is None:
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


def _fit(result: Fit | Selection) -> Fit:
    return result.fit if isinstance(result, Selection) else result


def _description(result: Fit | Selection, seed: int) -> str:
    fit = _fit(result)
    text = f"Identified from {fit.curves.source} by {fit.method}, seed {seed}"
    if fit.interrupted:
        text += f", interrupted: the best of the {_finished(result)}"
    return f"{text}."


def _finished(result: Fit | Selection) -> str:
    if isinstance(result, Selection):
        return f"{len(result.candidates)} models tried so far"
    return f"{len(result.trials)} finished trials"


def _suit(
    fit: Fit,
    joint: str,
    name: str,
    description: str,
    base: Suit | None,
    found: Uncertainty | None,
) -> Suit:
    return Suit.from_fits(
        {joint: fit},
        name=name,
        description=description,
        base=base,
        samples={joint: found.samples if found else ()},
        left_open={joint: [*_left_open(fit, found)]},
    )


def _left_open(fit: Fit, found: Uncertainty | None) -> Iterator[str]:
    """Yields what the curves leave open and no sample has, as phrases."""
    if found:
        yield from found.left_open
    if fit.method != AUTO:
        yield "other kinds of model"
    if fit.verdict in MISSING:
        yield MISSING[fit.verdict]


def _write(folder: RunFolder, joint: str, fit: Fit, summary: dict[str, Any]) -> None:
    folder.json("result.json", summary)
    write_trials(folder, "trials.csv", {joint: {fit.method: fit}})
    folder.figure("loops", loops_figure({joint: fit.curves}, {joint: {fit.model_name: fit}}))


def _end(result: Fit | Selection) -> None:
    """Ends the command as a fit demands that was interrupted, or is not what was asked for."""
    fit = _fit(result)
    if fit.interrupted:
        raise KeyboardInterrupt(f"the best of the {_finished(result)} is kept")
    if fit.verdict == NOT or any(one.code == "open" for one in fit.remarks):
        raise SystemExit(NOT_DESCRIBED)
