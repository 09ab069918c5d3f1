"""`activesuit validate`: compares a believed suit with the true suit, by torque and relief."""

from pathlib import Path
from typing import Annotated, Any

import tyro

from ...assets import load_suit
from ...checks import once
from ...envs.evaluation import FIRST_SEED
from ...envs.evaluation.suit_validation import WEIGHTLESS
from ...envs.evaluation.suit_validation import validate as validate_suits
from ...envs.evaluation.verdict import CurveError, CurvePrediction, curve_errors
from ...errors import InputError
from ...identification import load_curves
from ..folders import RunFolder
from ..measured_joint import joint_of
from ..options import Force, Json, Motions, SuitName, choice, joints, policies, suits
from ..output import progress
from ..scene import refuse_observed, scene
from ..writer import Report, conclude


def validate(
    suits: Annotated[tuple[Annotated[str, choice(suits)], ...], tyro.conf.Positional],
    /,
    plant: tuple[SuitName, ...] = (),
    policy: Annotated[str, choice(policies)] = "feedforward",
    samples: bool = False,
    held_out: tuple[Path, ...] = (),
    joint: Annotated[str | None, choice(joints)] = None,
    motions: Motions = 20,
    seed: int = FIRST_SEED,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
    **options: Any,
) -> None:
    """Validate an identified suit model in closed loop.

    `activesuit validate my-suit.json` shows how well a controller works with the model of one
    identified suit: the true suit of each motion is drawn from the model and its samples, which the
    curves allow too (`activesuit identify` writes the samples). With --plant the controller
    believes one suit and the simulated arm wears another suit. The error of the believed torque
    along the motions decides the verdict; relief is compared with the relief of the same controller
    with the true model. By default there is no gravity, so that only the suit's torque remains.
    Several suits or plants make a matrix.

    Args:
        suits: Suits that the controller believes: names of shipped suits, or paths of suit files.
        plant: Suits that are simulated: names of shipped suits, or paths of suit files; by default
            the believed suit with its samples.
        policy: Policy, with its options, or MODULE:CLASS of your own. The policy believes the suits
            if it has the option `suit`.
        samples: Simulate the model of PLANT or one of its samples, drawn anew for each motion.
        held_out: CSV files of measured curves: predict their torque, and simulate nothing.
        joint: Joint on which these curves were measured; by default the joint in the file name
            (elbow.csv).
        seed: Seed of the first motion.
        out: Folder for result.json, the first motions, report.html, and the matrix as PNG and SVG:
            a new or an empty folder.
    """
    if not suits:
        raise InputError("no suit is given: name one that the controller believes")
    if held_out and (samples or plant):
        raise InputError(
            "--samples and --plant name suits to simulate, and --held-out simulates nothing: leave "
            "one out"
        )
    if joint is not None and not held_out:
        raise InputError(f"--joint is {joint!r} and there are no curves: add --held-out")
    if "suit" in options:
        raise InputError(f"--suit is {options['suit']!r}, and --plant names the simulated suits")
    title = "Validation of a suit model"
    if held_out:
        settings = {"suits": suits, "held_out": held_out, "joint": joint}
        predicted, about = _predicted(suits, held_out, joint), ", ".join(x.name for x in held_out)
        folder = RunFolder(out, force=force) if out else None
        conclude(Report.of(predicted, title, about, settings=settings), folder, json)
        return
    chosen = scene({**options, "suit": (plant or suits)[0]}, usual={"gravity": WEIGHTLESS})
    refuse_observed(chosen.options, [policy])
    folder = RunFolder(out, force=force) if out else None
    del chosen.options["suit"]
    with progress("validate") as bar:
        found = validate_suits(
            chosen.env,
            suits,
            plant,
            policy=policy,
            samples=samples,
            motions=motions,
            seed=seed,
            on_step=bar.move_to,
            **chosen.options,
        )
    settings = {**found.settings, "suits": suits, "plant": [*found.plants]}
    conclude(Report.of(found, title, found.place, settings=settings), folder, json)


def _predicted(
    suits: tuple[str, ...], files: tuple[Path, ...], joint: str | None
) -> CurvePrediction:
    """Returns the errors of suits on measured curves."""
    once("suits", suits)
    found: dict[str, dict[str, list[CurveError]]] = {}
    notes = []
    for path in files:
        name, curves = str(joint_of(path, joint)), load_curves(path)
        measured = curves.held_out() or curves
        series = {curve.name: (curve.angle, curve.torque) for curve in measured}
        for suit in suits:
            entry = load_suit(suit).joints.get(name)
            if entry is None:
                raise InputError(f"the suit {suit!r} has no {name}, and {path.name!r} is of it")
            if curves.sha256 == entry.data_sha256 and not curves.held_out():
                notes.append(f"{name}: {suit} was fitted to {path.name}, which tests nothing")
            found.setdefault(suit, {}).setdefault(name, []).extend(curve_errors(entry, series))
    return CurvePrediction(errors=found, notes=notes)
