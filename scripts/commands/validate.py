"""`activesuit validate`: a believed suit against the true one, first its torque, then relief."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any

import tyro

from ...assets import load_suit
from ...checks import at_least, check_seed, once
from ...envs.evaluation import FIRST_SEED, Evaluation, Trace
from ...envs.evaluation.failures import why_remarks
from ...envs.evaluation.figures import motion_plots
from ...envs.evaluation.report import cuff_remarks, score_table, trace_columns
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.evaluation.validation import (
    LIMITS,
    CurveError,
    Validation,
    believed_joints,
    curve_errors,
    verdict,
)
from ...envs.evaluation.validation import validate as validate_suits
from ...envs.evaluation.validation_report import (
    RULE,
    answer,
    covered_text,
    curve_table,
    matrix_plot,
    matrix_table,
    names_of,
    story,
    torque_table,
)
from ...envs.model import ASSISTED
from ...envs.policies import policy_spec
from ...errors import InputError
from ...identification import load_curves
from ..folders import RunFolder
from ..measured_joint import joint_of
from ..options import Force, Json, Motions, SuitName, choice, joints, policies, suits
from ..output import progress
from ..scene import Scene, refuse_observed, scene
from ..writer import Report, conclude

GRAVITY = "microgravity"
OTHERS = 4  # number of policies and references beside those that believe a suit
Cells = dict[tuple[str, str], Validation]  # keys are believed and true suit


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

    `activesuit validate my-suit.json` tells how well a controller works that has the model of one
    identified suit: the true suit of each motion is drawn among the model and its samples, which
    the curves allow too (`activesuit identify` writes them). With --plant the controller believes
    one suit and the simulated arm wears another: the error of the believed torque along the motions
    decides the verdict, and relief stands beside that by the same controller with the true model.
    By default there is no gravity, so that only the suit's torque remains. Several suits or plants
    make a matrix.

    Args:
        suits: Suits that the controller believes: names of shipped ones, or paths of suit files.
        plant: Suits that are simulated: names of shipped ones, or paths of suit files; by default
            the one suit that is believed, with its samples.
        policy: Policy, with its options; one of your own as MODULE:CLASS. It believes the suits if
            it takes the option `suit`.
        samples: Simulate PLANT's own model or one of its samples, drawn anew for each motion.
        held_out: CSV files of measured curves: predict their torque, and simulate nothing.
        joint: Joint on which these curves were measured; by default the file name tells it
            (elbow.csv).
        seed: Seed of the first motion.
        out: Folder for result.json, the first motions, report.html, and the matrix as PNG and SVG:
            a new or an empty one.
    """
    if not suits:
        raise InputError("no suit is given: name one that the controller believes")
    once("suits", suits)
    once("plants", plant)
    if not plant and not held_out:
        plant, samples = _itself(suits), True
    for suit in (*suits, *plant):
        load_suit(suit)
    if held_out and samples:
        raise InputError(
            "--samples draws suits to wear, and --held-out simulates nothing: leave one out"
        )
    if held_out:
        report = _predicted(suits, held_out, joint)
        folder = RunFolder(out, force=force) if out else None
        conclude(report, folder, json)
        return
    if joint is not None:
        raise InputError(f"--joint is {joint!r} and there are no curves: add --held-out")
    policy_spec(policy)
    at_least("motions", motions, FEWEST_MOTIONS)
    check_seed(seed)
    if "suit" in options:
        raise InputError(f"--suit is {options['suit']!r}, and --plant names the simulated suits")
    usual = {"gravity": GRAVITY}
    scenes = {true: scene({**options, "suit": true}, usual=usual) for true in plant}
    for chosen in scenes.values():
        refuse_observed(chosen.options, [policy])
        believed_joints(chosen.env, {suit: suit for suit in suits}, policy, **chosen.options)
    if samples:
        drawn = {"suit": "samples"}
        scenes = {
            true: replace(
                chosen,
                options={
                    **chosen.options,
                    "randomize": {**chosen.options.get("randomize", {}), **drawn},
                },
            )
            for true, chosen in scenes.items()
        }
    folder = RunFolder(out, force=force) if out else None
    cells, evaluations = _simulated(suits, scenes, policy, motions, seed)
    conclude(_report(cells, evaluations, scenes, policy, motions, seed), folder, json)


def _itself(suits: tuple[str, ...]) -> tuple[str]:
    """Returns the one suit whose samples are the true ones."""
    if len(suits) != 1:
        raise InputError(f"{len(suits)} suits are given and no --plant: name the simulated suit")
    (suit,) = suits
    joints = load_suit(suit).joints
    if not any(joints[name].samples for name in ASSISTED if name in joints):
        raise InputError(
            f"the suit {suit!r} has no samples of what its curves allow: identify it again with "
            "--samples 20, or name the simulated suit by --plant"
        )
    return (suit,)


def _simulated(
    suits: tuple[str, ...],
    scenes: Mapping[str, Scene],
    policy: str,
    motions: int,
    seed: int,
) -> tuple[Cells, dict[str, Evaluation]]:
    """Simulates all cells: each believed suit with each plant."""
    cells: Cells = {}
    evaluations, labels = {}, names_of(suits)
    total = (len(suits) + OTHERS) * len(scenes) * motions
    with progress("validate", total) as bar:

        def report(name: str, traces: list[Trace]) -> None:
            del name
            bar.advance(len(traces))

        for true, chosen in scenes.items():
            evaluations[true], found = validate_suits(
                chosen.env,
                {labels[suit]: suit for suit in suits},
                policy=policy,
                motions=motions,
                seed=seed,
                on_policy=report,
                threads=0,
                **chosen.options,
            )
            cells |= {(suit, true): found[labels[suit]] for suit in suits}
    return cells, evaluations


def _report(
    cells: Cells,
    evaluations: Mapping[str, Evaluation],
    scenes: Mapping[str, Scene],
    policy: str,
    motions: int,
    seed: int,
) -> Report:
    chosen = next(iter(scenes.values()))
    result: dict[str, Any] = {"env": chosen.env, "policy": policy}
    result |= {"motions": motions, "seed": seed, **chosen.options, "limits": LIMITS}
    del result["suit"]
    settings = {**result, "suits": [*dict.fromkeys(suit for suit, _ in cells)], "plant": [*scenes]}
    result["cells"] = [
        {"believed": suit, "plant": true, **one.to_dict()} for (suit, true), one in cells.items()
    ]
    result["evaluations"] = {true: found.to_dict() for true, found in evaluations.items()}
    place = f"{chosen.env}, {chosen.options['gravity']}, {policy}"
    tables, remarks, plots = {}, [], {}
    first = {name: one[0] for name, one in next(iter(evaluations.values())).traces.items()}
    if len(cells) > 1:
        tables[f"Torque error, relief and verdict: {place}"] = matrix_table(cells)
        remarks.append(covered_text(cells))
        plots["matrix"] = matrix_plot(cells)
    else:
        ((suit, true),) = cells
        scores = list(evaluations[true].scores.values())
        title = f"believes {suit}, wears {true}"
        tables[f"Torque, believed less true: {title}"] = torque_table(cells[suit, true])
        tables[f"Human torque: {place}"] = score_table(scores, evaluations[true])
        found = cells[suit, true]
        believed = load_suit(suit)
        drawn = chosen.options.get("randomize", {}).get("suit") == "samples"
        if found.same and drawn:
            remarks += answer(found, suit, believed, policy, evaluations[true])
        else:
            remarks += story(found, suit, believed)
        remarks += _lacking(suit, true)
        remarks += [*why_remarks(scores), *cuff_remarks(scores)]
    judged = any(one.verdict for one in cells.values())
    return Report(
        heading="Validation of a suit model",
        about=place,
        result=result,
        tables=tables,
        answer=[*remarks, *[RULE] * judged],
        columns={"traces.csv": trace_columns(first)},
        plots=plots | motion_plots(first),
        settings=settings,
    )


def _lacking(believed: str, true: str) -> Iterator[str]:
    for joint in ASSISTED:
        if joint not in load_suit(true).joints:
            yield f"{joint}: nothing to assist, because {true} has no such joint"
        elif joint not in load_suit(believed).joints:
            yield f"{joint}: not assisted, because {believed} has no such joint"


def _predicted(suits: tuple[str, ...], files: tuple[Path, ...], joint: str | None) -> Report:
    """Returns what suits predict of measured curves."""
    found: dict[str, dict[str, list[CurveError]]] = {}
    remarks = []
    for path in files:
        name, curves = joint_of(path, joint), load_curves(path)
        measured = curves.held_out() or curves
        series = {curve.name: (curve.angle, curve.torque) for curve in measured}
        for suit in suits:
            entry = load_suit(suit).joints.get(name)
            if entry is None:
                raise InputError(f"the suit {suit!r} has no {name}, and {path.name!r} is of it")
            if curves.sha256 == entry.data_sha256 and not curves.held_out():
                remarks.append(f"{name}: {suit} was fitted to {path.name}, which tests nothing")
            found.setdefault(suit, {}).setdefault(name, []).extend(curve_errors(entry, series))
    result = {
        suit: {
            name: {"verdict": _worst(errors), "curves": [asdict(error) for error in errors]}
            for name, errors in by_joint.items()
        }
        for suit, by_joint in found.items()
    }
    for suit, by_joint in result.items():
        remarks += [f"{suit}, {name}: {one['verdict']}" for name, one in by_joint.items()]
    remarks.append(f"{RULE} Of curves, the worst one decides.")
    return Report(
        heading="Validation of a suit model",
        about=", ".join(path.name for path in files),
        result={"limits": LIMITS, "suits": result},
        tables={"Torque, predicted less measured": curve_table(found)},
        answer=remarks,
        settings={"suits": suits, "held_out": files, "joint": joint},
    )


def _worst(errors: list[CurveError]) -> str:
    return verdict(max(error.nrmse for error in errors))
