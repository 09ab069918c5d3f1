"""`activesuit identify`: fits a hysteresis model to a file of measured curves."""

from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Annotated, get_args

import tyro

from ...assets import Suit, load_suit
from ...checks import at_least
from ...errors import InputError, shown
from ...identification import Corrections, Curves, load_curves, select
from ...identification import identify as identify_curves
from ...identification.corrections import averaged
from ...identification.cycles import cycles_of
from ...identification.fits.registry import FITS
from ...identification.identify import NONE
from ...identification.left_out import questions
from ...identification.methods import DEFAULT_MODEL, Magnetic, method_names, method_of
from ...identification.objective import InitialTorque, Loss, Normalize
from ...identification.report import Identification
from ...identification.residual.verdict import NOT
from ...text import say
from ..curve_joints import joint_of
from ..folders import RunFolder
from ..intended import intended_motions, needed_coverage
from ..options import Force, Json, Seed, Use, choice, joints, named_values, optional_number, suits
from ..output import progress
from ..writer import Report, conclude

NOT_DESCRIBED = 3  # exit code; also where the tare that was to be fitted is not determined
AUTO, CERTIFIED = "auto", "certified"  # methods; of auto `select` chooses the model
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
    uncertainty = result.uncertainty(samples=samples, seed=seed) if samples else None
    found = Identification(
        result=result,
        seed=seed,
        uncertainty=uncertainty,
        corrections=corrections,
        use=use,
        needed=needed,
    )
    fit = found.fit
    answer = found.sentences()
    if folder and joint_name and base is None:
        name = joint_name.replace("_", " ")
        answer.append(f"suit: it resists {name} only; --base mock-suit adds the other joints")
    label = joint_name or Path(fit.curves.source).stem
    report = Report(
        heading="Identified model",
        about=f"{family.source}, {label.replace('_', ' ')}",
        result=found.to_dict(),
        tables=found.tables(),
        answer=answer,
        columns=found.columns(label),
        plots=found.plots(label),
        settings={
            **{"curves": curves, "method": method, **beside, "initial_torque": initial_torque},
            **{"corrections": asdict(corrections), "samples": samples, "seed": seed},
            **{"for": use, "joint": joint_name, "base": base, "data_sha256": family.sha256},
        },
    )
    if folder and joint_name:
        suit = Suit.from_fits(
            {joint_name: fit},
            name=curves[0].stem,
            description=found.description,
            base=others,
            samples={joint_name: uncertainty.samples if uncertainty else ()},
            left_open={joint_name: found.left_open},
        )
        suit.save(folder / "suit.json")
    conclude(report, folder, json)
    if fit.interrupted:
        raise KeyboardInterrupt(f"the best of the {found.finished} is kept")
    if fit.verdict == NOT or any(one.code == "open" for one in fit.remarks):
        raise SystemExit(NOT_DESCRIBED)


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
