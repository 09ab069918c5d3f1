"""`activesuit identify`: fits a hysteresis model to a file of measured curves."""

from pathlib import Path
from typing import Annotated, Any, get_args

import tyro

from ...assets import Suit, load_suit
from ...checks import at_least
from ...errors import InputError
from ...identification import Coverage, Curves, Fit, Trial, averaged_cycles, load_curves
from ...identification import identify as identify_curves
from ...identification.cycles import cycles_of
from ...identification.figures import loops_figure
from ...identification.fits.play import Play
from ...identification.fits.rate import Rate
from ...identification.fits.registry import FITS
from ...identification.objective import InitialTorque, Loss, Normalize
from ...identification.options import METHODS
from ...identification.residual.verdict import NOT, NOT_BEYOND
from ...identification.softening import Softens
from ...identification.tare import Tare
from ...identification.uncertainty.uncertainty import Uncertainty
from ..curve_joints import joint_of
from ..intended import needed_coverage
from ..options import Force, Json, Seed, Use, choice, joints, suits
from ..output import RunFolder, progress, say, table, to_json
from ..reports.fits import (
    band_table,
    candidate_table,
    fit_summary,
    quality_table,
    uncertainty_summary,
    uncertainty_table,
    write_trials,
)
from ..reports.parameters import parameter_table

NOT_DESCRIBED = 3  # exit code


def identify(
    curves: Annotated[Path, tyro.conf.Positional],
    /,
    model: Annotated[str | None, choice(lambda: FITS)] = None,
    method: Annotated[str, choice(lambda: METHODS)] = "certified",
    objective: Annotated[Loss | None, choice(lambda: get_args(Loss))] = None,
    normalize: Annotated[Normalize | None, choice(lambda: get_args(Normalize))] = None,
    initial_torque: InitialTorque | None = None,
    tare: Tare = 0.0,
    average_cycles: bool = False,
    rate: Annotated[Rate, choice(lambda: get_args(Rate))] = "none",
    play: Annotated[Play, choice(lambda: get_args(Play))] = "none",
    softening: Annotated[Softens, choice(lambda: get_args(Softens))] = "none",
    trials: int | None = None,
    seed: Seed = 0,
    workers: int = -1,
    samples: int = 0,
    use: Use = None,
    joint: Annotated[str | None, choice(joints)] = None,
    base: Annotated[str | None, choice(suits)] = None,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Identify a hysteresis model from measured angle-torque curves.

    Curves with role "predict" are kept out of the fit and used to test it. The verdict says whether
    the model describes the curves; if it does not, all is written and the exit code is 3.

    Args:
        curves: CSV file with the columns curve, angle_rad (or angle_deg), torque_nm, and
            optionally role (fit or predict), weight, and time_s.
        model: Hysteresis model to fit, jiles-atherton by default; asymmetric is the same beside a
            polynomial. The method certified has all models, the other methods only jiles-atherton.
        method: Method of the fit: certified finds a model that is safe to simulate; auto finds the
            simplest of all models that predicts curves left out of its fit; the others are the
            papers' swarms and optimizers of other libraries (ga and cma-es need the extra
            `compare`).
        objective: Quantity that a swarm or optimizer minimizes: nrmse (by default), paper (eq. 7
            of Li et al. 2022), sse, or robust (against outliers).
        normalize: Torque that divides the errors of the objective: the largest one of the family
            (by default) or of each curve.
        initial_torque: Torque with which each curve begins: a number in N·m (by default 0),
            measured (the first sample of the curve) or identified (one number for all curves).
            Only jiles-atherton has this choice; the fits of other models identify it.
        tare: Offset of the torque sensor in N·m, which is taken off all curves; zero takes the mean
            torque with which they begin, noise included, fitted the offset that the certified fit
            prefers.
        average_cycles: Replace all cycles of each record but the first by their mean; the cycles
            of a record must turn at the same two angles.
        rate: Part of the torque that depends on the rate, fitted beside the model: none, viscous
            (a dashpot) or relaxing (a dashpot and a Maxwell element); the file needs time_s then.
        play: Play in the transmission, whose gap is fitted before the model (fitted), or none.
        softening: Change of the torque over the cycles of the file, which is found and taken off
            the curves, and written to suit.json (fitted), or none.
        trials: Number of independent runs, of which the best counts; by default 1 for certified
            and 30 for swarms and optimizers.
        workers: Number of threads; -1 uses all cores.
        samples: Number of further models in suit.json that the curves allow too, to randomize the
            simulation with; the uncertainty of the parameters is shown as well. With the method
            auto they are of all models that predict nearly as well as the best.
        joint: Joint on which the curves were measured; by default the file name tells it
            (elbow.csv).
        base: Suit whose other joints suit.json takes over; by default it has this joint only.
        out: Folder for suit.json, result.json, trials.csv and the loops as PNG and SVG: a new or an
            empty one, or that of an earlier identify.
    """
    family = load_curves(curves)
    if average_cycles:
        if softening != "none":
            raise InputError("--average-cycles hides what --softening looks for: leave one out")
        family = _averaged(family, quiet=json)
    if base is not None and not out:
        raise InputError(f"--base {base} needs --out: its joints go into suit.json there")
    at_least("samples", samples, 0)
    joint_name = joint_of(curves, joint) if out or joint is not None else None
    needed = needed_coverage(family, curves, use, joint)
    others = None if base is None else load_suit(base)
    folder = RunFolder(out, "identify", force=force) if out else None
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
            tare=tare,
            rate=rate,
            play=play,
            softening=softening,
            trials=trials,
            seed=seed,
            workers=workers,
            on_trial=report,
            needed=needed,
        )
    found = fit.uncertainty(samples=samples, seed=seed) if samples else None
    summary = _summary(fit, seed, use, needed, found)
    if json:
        print(to_json(summary))
    else:
        bands = summary["ensemble"]["bands"] if fit.ensemble else {}
        _print(fit, curves, use, found, bands)
    if folder and joint_name:
        suit = Suit.from_fits(
            {joint_name: fit},
            name=curves.stem,
            description=_description(fit, curves, seed),
            base=others,
            samples={joint_name: found.samples if found else ()},
        )
        with folder.together() as new:
            suit.save(new / "suit.json")
            new.json("result.json", summary)
            _write(new, joint_name, fit)
        if not json:
            say(f"wrote {folder.path}/suit.json, result.json, trials.csv, loops.png")
    if fit.interrupted:
        raise KeyboardInterrupt(f"the best of the {_finished(fit)} is kept")
    if fit.verdict == NOT:
        raise SystemExit(NOT_DESCRIBED)


def _averaged(family: Curves, *, quiet: bool) -> Curves:
    counts = ", ".join(f"{cycles_of(one)} of {one.name}" for one in family)
    averaged = averaged_cycles(family)
    if not quiet:
        say(f"mean of the cycles after the first: {counts}")
    return averaged


def _summary(
    fit: Fit, seed: int, use: str | None, needed: Coverage | None, found: Uncertainty | None
) -> dict[str, Any]:
    """Returns what result.json and --json hold."""
    coverage = {
        "for": use,
        "measured": fit.coverage and fit.coverage.to_dict(),
        "needed": needed and needed.to_dict(),
        "shortfalls": fit.shortfalls,
    }
    summary = {**fit_summary(fit, seed), "coverage": coverage}
    return {**summary, "uncertainty": uncertainty_summary(found)} if found else summary


def _print(
    fit: Fit,
    curves: Path,
    use: str | None,
    found: Uncertainty | None,
    bands: dict[str, dict[str, float]],
) -> None:
    if fit.candidates:
        table(f"models for {curves.name}", *candidate_table(fit), left=1)
        say(f"{fit.why}\n")
    header, rows = parameter_table({"value": fit.model})
    start = fit.initial_torque
    begins = start if isinstance(start, str) else f"{start:.5g}"
    rows = [*rows, ["initial torque [N·m]", begins]]
    if fit.tare:
        rows.append(["tare [N·m]", f"{fit.tare:.5g}"])
    if fit.softening:
        first, steady, cycles, _ = fit.softening
        change = f"{first:.3f} first, {steady:.3f} steady, 1/e in {cycles:.3g} cycles"
        rows.append(["torque over the last", change])
    table(curves.name, header, rows, left=1)
    table("quality", *quality_table({curves.stem: {fit.method: fit}}))
    if bands:
        table("bands of nominal 90 % over kinds of model", *band_table(bands))
    if found:
        table("how sure the parameters are", *uncertainty_table(fit, found), left=1)
    why = ": they hold no loops inside loops, and no intended motion is named (--for)"
    say(f"verdict: the model {fit.verdict}{why if fit.verdict == NOT_BEYOND and not use else ''}")
    for remark in (*fit.diagnostics, *(found.sloppy if found else ())):
        say(f"note: {remark}")


def _description(fit: Fit, curves: Path, seed: int) -> str:
    text = f"Identified from {curves.name} by {fit.method}, seed {seed}"
    if fit.interrupted:
        text += f", interrupted: the best of the {_finished(fit)}"
    return f"{text}."


def _finished(fit: Fit) -> str:
    if fit.candidates:
        return f"{len(fit.candidates)} models tried so far"
    return f"{len(fit.trials)} finished trials"


def _write(folder: RunFolder, joint: str, fit: Fit) -> None:
    write_trials(folder, "trials.csv", {joint: {fit.method: fit}})
    folder.figure("loops", loops_figure({joint: fit.curves}, {joint: {fit.model_name: fit}}))
