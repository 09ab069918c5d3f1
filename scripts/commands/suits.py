"""`activesuit suits`: lists the shipped suits, or shows and checks one suit."""

import math
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import tyro

from ...assets import JOINTS, Suit, SuitJoint, load_suit, save_suit, suit_names
from ...errors import InputError
from ...files import check_target, replacing
from ...hysteresis import HysteresisModel, PoleError
from ...hysteresis.certificate import ALL_ANGLES
from ..options import Force, Json, choice
from ..options import suits as known_suits
from ..output import RunFolder, say, table, to_json
from ..reports.parameters import parameter_table

LOSS_FACTOR = (
    "loss factor: what one steady cycle over the joint's range dissipates, over the work that goes "
    "into the joint in it. It rests on the fit of the mock suit's published loops and on no "
    "measurement of a pressurized suit; a gas alone gives all of P dV/dtheta back, which is 0."
)


def suits(
    suit: Annotated[str | None, choice(known_suits), tyro.conf.Positional] = None,
    /,
    pressure: float | None = None,
    export: Path | None = None,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """List the shipped suits, or show and check one.

    If it is not safe to simulate, the exit code is 2.

    Args:
        suit: Name of a shipped suit, or path of a suit file; by default all shipped suits are
            listed.
        pressure: Operating pressure at which the suit is shown [kPa]; by default its own.
        export: Path of a new suit file that holds the suit at that pressure.
        out: Folder for the torque-angle loops of its joints, as PNG and SVG: a new or an empty
            one.
    """
    if suit is None:
        for flag, value in (("--pressure", pressure), ("--export", export), ("--out", out)):
            if value is not None:
                raise InputError(
                    f"{flag} is {value}, but of which suit: give one of {', '.join(suit_names())}, "
                    "or a suit file"
                )
        _list(json)
        return
    shown = load_suit(suit)
    if pressure is not None:
        shown = shown.at_pressure(pressure)
    if out and not shown.joints:
        raise InputError(f"--out is {out}, but {shown.name} resists no joint: leave --out away")
    problems = [f"{joint} {what}" for joint, e in shown.joints.items() if (what := _problem(e))]
    if export:
        check_target(export, force=force)
    folder = RunFolder(out, force=force) if out else None
    if json:
        print(to_json(_content(shown, safe=not problems)))
    else:
        _show(shown)
    written = _write(shown, export, folder, force)
    if written and not json:
        say(f"wrote {', '.join(map(str, written))}")
    if problems:
        raise InputError(
            f"{shown.name} is not safe to simulate: {'; '.join(problems)}; identify its curves "
            "by method certified, or simulate with --allow-uncertified"
        )
    if not json:
        print("Safe to simulate: no motion makes its torque infinite or gets energy out of it.")


def _list(json: bool) -> None:
    shipped = [load_suit(name) for name in suit_names()]
    if json:
        fields = {"label", "pressure_kpa", "description"}
        print(
            to_json(
                {
                    suit.name: {
                        **suit.model_dump(include=fields),
                        "joints": [*suit.joints],
                        "loss_factor": {j: _loss_factor(e) for j, e in suit.joints.items()},
                    }
                    for suit in shipped
                }
            )
        )
        return
    rows = [
        [
            suit.name,
            suit.label or "-",
            ", ".join(joint.removesuffix("_flexion").replace("_", " ") for joint in suit.joints),
            _pressure(suit),
        ]
        for suit in shipped
    ]
    table("suits", ["name", "label", "joints", "pressure"], rows, left=3)
    rows = [
        [
            joint,
            *(_shown_loss(suit.joints[joint]) if joint in suit.joints else "-" for suit in shipped),
        ]
        for joint in JOINTS
    ]
    table("loss factor", ["joint", *(suit.name for suit in shipped)], rows, left=1)
    say(f"{LOSS_FACTOR}\n")
    for suit in shipped:
        say(f"{suit.name}: {suit.description}\n")


def _content(suit: Suit, *, safe: bool) -> dict[str, Any]:
    content = {**suit.model_dump(), "safe": safe}
    for joint, entry in suit.joints.items():
        content["joints"][joint]["certificate"] = asdict(entry.model.certificate())
        content["joints"][joint]["loss_factor"] = _loss_factor(entry)
    return content


def _show(suit: Suit) -> None:
    say(f"{suit.name}: {suit.description}\n")
    say(f"label: {suit.label or '-'}; pressure: {_pressure(suit)}\n")
    if not suit.joints:
        print("It resists no joint.")
        return
    names = {joint: joint.replace("_", "\n") for joint in suit.joints}
    header, rows = parameter_table({names[j]: entry.model for j, entry in suit.joints.items()})
    columns = [_column(entry) for entry in suit.joints.values()]
    rows += [[quantity, *(column[quantity] for column in columns)] for quantity in columns[0]]
    table("models", header, rows, left=1)
    for joint, entry in suit.joints.items():
        say(f"{joint}: {entry.source}")
    print()


def _pressure(suit: Suit) -> str:
    return "unknown" if suit.pressure_kpa is None else f"{suit.pressure_kpa:g} kPa"


def _softening(entry: SuitJoint) -> str:
    if entry.softening is None:
        return "-"
    softening = entry.softening
    return f"{softening.first:.3g}, {softening.steady:.3g},\n{softening.cycles:.3g} cycles"


def _column(entry: SuitJoint) -> dict[str, str]:
    low, high = entry.range
    torques = sorted(_end_torque(entry, sample) for sample in entry.samples)
    return {
        "grade": entry.grade,
        "torque of the first cycle,\nof many, falls to 1/e in": _softening(entry),
        "start [rad, N·m]": f"{entry.start_angle:.2f}, {entry.start_torque:.2f}",
        "range [rad]": f"{low:.2f} .. {high:.2f}",
        "torque at its end [N·m]": f"{_end_torque(entry, entry.model):.2f}",
        "loss factor": _shown_loss(entry),
        "samples": str(len(torques)),
        "their torque there [N·m]": f"{torques[0]:.2f} .. {torques[-1]:.2f}" if torques else "-",
        "certificate margin": f"{entry.model.certificate().margin:.3f}",
        "safe in its range": "yes" if _is_safe(entry.model, entry.range) else "NO",
        "safe to simulate": "NO" if _problem(entry) else "yes",
    }


def _end_torque(entry: SuitJoint, model: HysteresisModel) -> float:
    """Returns the resistance [N·m] when first bent to the end of the range."""
    try:
        return entry.response([entry.range[1]], model)[0]
    except PoleError:
        return math.inf


def _loss_factor(entry: SuitJoint) -> float | None:
    """Returns the share of the loading work that a steady cycle dissipates, or None without one."""
    try:
        return entry.steady_cycle().loss_factor
    except (InputError, PoleError):
        return None


def _shown_loss(entry: SuitJoint) -> str:
    factor = _loss_factor(entry)
    return "-" if factor is None else f"{factor:.2f}"


def _problem(entry: SuitJoint) -> str | None:
    """Returns the reason why a joint is not safe to simulate, or None."""
    model = entry.model
    if not _is_safe(model):
        certificate = model.certificate()
        return (
            f"has certificate margin {certificate.margin:.3g} and dissipative = "
            f"{certificate.dissipative}, and needs a margin above 0 and True"
        )
    if not model.start_is_certified(model.start(entry.start_angle, entry.start_torque)):
        return (
            f"begins at {entry.start_angle:g} rad with {entry.start_torque:g} N·m, outside its "
            "certificate"
        )
    return None


def _is_safe(model: HysteresisModel, span: tuple[float, float] = ALL_ANGLES) -> bool:
    certificate = model.certificate(span)
    return certificate.certified and certificate.dissipative


def _write(suit: Suit, export: Path | None, folder: RunFolder | None, force: bool) -> list[Path]:
    """Writes the suit file and the figures that were asked for; returns their paths."""
    written = []
    if export:
        with replacing(export, force=force) as scratch:
            save_suit(suit, scratch)
        written.append(export)
    if folder:
        from ..reports.suit_figure import (
            suit_figure,  # draws, which takes most of a second to import
        )

        folder.figure("loops", suit_figure(suit))
        written += [folder / "loops.png", folder / "loops.svg"]
    return written
