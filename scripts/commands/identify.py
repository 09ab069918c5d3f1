"""`activesuit identify`: fits a hysteresis model to a file of measured curves."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, get_args

import tyro

from ...assets import Suit, load_suit
from ...errors import InputError, shown
from ...identification import Corrections, load_curves
from ...identification import identify as identify_curves
from ...identification.fit_curves import NONE
from ...identification.fits.objective import InitialTorque, Loss, Normalize
from ...identification.fits.registry import FITS
from ...identification.identify import AUTO
from ...identification.judging.sentences import NOT
from ...identification.methods import Magnetic, method_names
from ...text import say
from ..folders import RunFolder
from ..measured_joint import intended_motions, is_task, joint_of
from ..options import Force, Json, Seed, Use, choice, joints, named_values, optional_number, suits
from ..output import progress
from ..writer import Report, conclude

NOT_DESCRIBED = 3  # exit code of a model that fails, and of a tare that is not determined
SAMPLES = 20  # number of further models in a suit file
_METHOD = (
    "Method of the fit: certified finds a model that is safe to simulate; auto finds the simplest "
    "model that predicts curves left out of its fit; magnetic finds the form of Jiles-Atherton for "
    "magnetization over a field; the other methods are swarms of the papers and optimizers of "
    "extensions."
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
    fix: tyro.conf.UseAppendAction[tuple[str, ...]] = (),
    bound: tyro.conf.UseAppendAction[tuple[str, ...]] = (),
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

    Curves with role "predict" are kept out of the fit and test the model. The verdict says whether
    the model describes the curves. The exit code is 3, and all files are written, if the model does
    not describe the curves, or if the curves do not determine a tare that --tare fit asks for.

    Args:
        curves: Files of curves: CSV with the columns curve, angle_rad (or angle_deg), torque_nm,
            and optionally role (fit or predict), weight, and time_s; or tables of a rig, whose
            separator, decimal mark, columns and units are found from the header.
        columns: Columns that the header does not show, by name or by number from 1 on, as
            angle="Winkel 1 [Grad]" torque=3: angle, torque, time, curve, role, weight.
        units: Units that the header does not show, as angle=deg torque="0.5 Nm/V" time=ms.
        decimal: Decimal mark of the numbers, for numbers that do not show the mark: . or ,
        model: Hysteresis model to fit, jiles-atherton by default; asymmetric adds a polynomial to
            jiles-atherton. The method certified fits all models, the other methods only
            jiles-atherton.
        objective: Quantity that a swarm or optimizer minimizes: nrmse (by default), paper (eq. 7
            of Li et al. 2022), sse, or robust (against outliers).
        normalize: Torque that divides the errors of the objective: the largest torque of the
            family (by default) or of each curve.
        initial_torque: Torque with which each curve begins: a number in N·m (by default 0),
            measured (the first sample of the curve) or identified (one number for all curves).
            Only jiles-atherton has this choice; the fits of other models identify the torque.
        fix: Parameter that keeps a value, as c=1.2, in the units of the table of the result (angles
            of jiles-atherton in degrees); give the option again for another parameter.
        bound: Lower and upper bound of a parameter, as k=1:50; k=1: and k=:50 have one bound.
        trials: Number of independent runs, of which the best run counts; by default 1 for certified
            and 30 for swarms and optimizers.
        workers: Number of threads; -1 uses all cores.
        samples: Number of further models in suit.json that the curves allow too, for `validate` and
            for the randomization of simulations; the uncertainty of the parameters is shown as
            well. The samples differ in noise and, where the curves limit these, in the offset of
            the sensor and in the damping; a line below the verdict names effects without samples.
            With the method auto the samples are of all models that predict nearly as well as the
            best model.
        joint: Joint on which the curves were measured; by default the joint in the file name
            (elbow.csv).
        base: Suit that gives the other joints of suit.json; by default suit.json has one joint.
        out: Folder for suit.json, result.json, trials.csv, report.html and the loops as PNG and
            SVG: a new or an empty folder.
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
    _check_suit_file(out, base, method)
    known = joint_of(curves[0], joint, needed=bool(out) or is_task(use))
    intended = intended_motions(use, known)
    joint = known if out or joint else None
    others = None if base is None else load_suit(base)
    folder = RunFolder(out, force=force) if out else None
    given: dict[str, Any] = {"model": model, "method": method, "trials": trials, "seed": seed}
    given |= {"objective": objective, "normalize": normalize, "initial_torque": initial_torque}
    given |= {"fixed": _fixed(fix), "bounds": _bounds(bound)}
    given["samples"] = (SAMPLES if out else 0) if samples is None else samples
    with progress(f"identify {family.source}") as bar:
        found = identify_curves(
            family,
            **given,
            corrections=corrections,
            use=use,
            intended=intended,
            workers=workers,
            on_step=bar.move_to,
        )
    label = joint or Path(family.source).stem
    answer = found.sentences()
    if folder and joint:
        drawn = found.uncertainty.samples if found.uncertainty else ()
        Suit.from_fits(
            {joint: found.fit},
            name=curves[0].stem,
            description=found.description,
            base=others,
            samples={joint: drawn},
            left_open={joint: found.left_open},
        ).save(folder / "suit.json")
        if others is None:
            name = joint.replace("_", " ")
            answer.append(f"suit: it resists {name} only; --base mock-suit adds the other joints")
    report = Report.of(
        found,
        "Identified model",
        f"{family.source}, {label.replace('_', ' ')}",
        answer=answer,
        columns=found.columns(label),
        plots=found.plots(label),
        settings={
            **{"curves": curves, **given, "method": found.fit.method},
            **{"corrections": asdict(corrections), "for": use, "joint": joint, "base": base},
            "data_sha256": family.sha256,
        },
    )
    conclude(report, folder, json)
    if found.fit.interrupted:
        raise KeyboardInterrupt(f"the best of the {found.finished} is kept")
    if found.verdict == NOT or any(one.code == "open" for one in found.fit.remarks):
        raise SystemExit(NOT_DESCRIBED)


def _fixed(given: Sequence[str]) -> dict[str, float]:
    """Returns the values of fixed parameters by name."""
    return {
        name: _number("--fix", name, text) for name, text in named_values("--fix", given).items()
    }


def _bounds(given: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Returns the bounds of parameters by name; a missing one is infinite."""
    found = {}
    for name, text in named_values("--bound", given).items():
        low, colon, high = text.partition(":")
        if not colon:
            raise InputError(f"--bound has {name}={shown(text)}: give LOW:HIGH, as {name}=1:50")
        ends = ((low, -math.inf), (high, math.inf))
        pair = [_number("--bound", name, one) if one else none for one, none in ends]
        found[name] = (pair[0], pair[1])
    return found


def _number(option: str, name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{option} has {name}={shown(text)}: give a number") from None


def _check_suit_file(out: Path | None, base: str | None, method: str | None) -> None:
    """Refuses a suit file of a magnetic model, and --base without a suit file."""
    if base is not None and not out:
        raise InputError(f"--base {base} needs --out: its joints go into suit.json there")
    if out and method == Magnetic.name:
        raise InputError(
            f"out is {shown(str(out))}: a suit file has joints, which a model of magnetics drives; "
            "leave it out, and take the result from --json"
        )
