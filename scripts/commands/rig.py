"""`activesuit rig`: measures a simulated suit joint as the paper measured a real one."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np

from ...envs.rig import Record, RigConfig, run_rig
from ...envs.rig.config import NOISE, RATE, SAMPLE_RATE
from ...envs.rig.figure import records_figure
from ...errors import InputError
from ...identification import Curve, load_motion, save_curves
from ..html.loops import measured_rows, write_loops
from ..html.writing import write_report
from ..options import Force, Json, Seed, SuitName, choice, joints
from ..output import RunFolder, say, table, to_json


def rig(
    suit: SuitName = "mock-suit",
    joint: Annotated[str, choice(joints)] = "elbow_flexion",
    motion: Path | None = None,
    turns: tuple[float, ...] = (),
    predict: tuple[float, ...] | None = None,
    start_angle: float | None = None,
    repeats: int = 1,
    rate: float = RATE,
    sample_rate: float = SAMPLE_RATE,
    noise: float = NOISE,
    drift: float = 0.0,
    torque_resolution: float | None = None,
    angle_resolution: float | None = None,
    bearing_friction: float = 0.0,
    seed: Seed = 0,
    out: Path = Path("runs/rig"),
    force: Force = False,
    json: Json = False,
) -> None:
    """Measure first-order curves of a suit joint on a simulated rig.

    Args:
        joint: Joint of the suit that is measured.
        motion: CSV file with the columns time_s and angle_rad of a motion to measure in place of
            first-order curves, as `activesuit design` writes it; the motor goes from
            reversal to reversal at the mean rate of each branch, from 0.01 to 0.5 rad/s.
        turns: Angles at which the curves turn back [rad]; by default those of the paper for
            shoulder and elbow, and fifths of the range for other joints.
        predict: Turns [rad] whose curves are kept out of a fit, to test it; by default the second,
            the fourth, ... but not the last.
        start_angle: Angle at which the curves begin and end [rad]; by default the one at which the
            suit's memory begins.
        repeats: Number of times that each curve goes to its turn and back.
        rate: Speed of the joint [rad/s], from 0.01 to 0.5.
        sample_rate: Sampling rate of the sensors [Hz], from 1 to 1000.
        noise: Standard deviation of the torque sensor's noise [N·m].
        drift: Drift of the torque sensor since the beginning of a curve [N·m/s].
        torque_resolution: Resolution of the torque sensor [N·m]; by default it has no steps.
        angle_resolution: Resolution of the encoder [rad]; by default it has no steps.
        bearing_friction: Friction of the bearings [N·m].
        out: Folder for the curves (JOINT.csv), config.json, report.html and the loops as PNG and
            SVG: a new or an empty one.
    """
    config = RigConfig(
        suit=suit,
        joint=joint,
        turns=turns,
        start_angle=start_angle,
        repeats=repeats,
        rate=rate,
        sample_rate=sample_rate,
        noise=noise,
        drift=drift,
        torque_resolution=torque_resolution,
        angle_resolution=angle_resolution,
        bearing_friction=bearing_friction,
        seed=seed,
        motion=_pairs(motion, joint) if motion else (),
    )
    if motion and predict is not None:
        raise InputError("--predict belongs to first-order curves: leave it out beside --motion")
    kept_out = _kept_out(config.turns, predict)
    folder = RunFolder(out, force=force)
    _report(config, kept_out, run_rig(config), folder, json)


def _report(
    config: RigConfig,
    kept_out: Sequence[float],
    records: Sequence[Record],
    folder: RunFolder,
    json: bool,
) -> None:
    names = {f"{turn:.2f}" for turn in kept_out}
    curves = [
        Curve(
            one.angle,
            one.torque,
            one.name,
            "predict" if one.name in names else "fit",
            time=one.time,
        )
        for one in records
    ]
    path = folder / f"{config.joint}.csv"
    title = f"{config.suit}, {config.joint.replace('_', ' ')}"
    measured = [_summary(curve) for curve in curves]
    header = ["curve", "role", "samples", "peak torque\n[N·m]", "work\n[J]"]
    rows = [[f"{v:.3f}" if isinstance(v, float) else str(v) for v in m.values()] for m in measured]
    folder.json("config.json", {**asdict(config), "predict": kept_out})
    folder.figure("loops", records_figure(title, records))
    save_curves(folder / path.name, curves, comments=(f"Measured on the simulated rig: {title}.",))
    write_loops(folder, measured_rows(config.joint, curves))
    write_report(
        *(folder, "rig", title),
        answer=[_answer(curves)],
        tables={title: (header, rows)},
        settings={**asdict(config), "predict": kept_out},
    )
    if json:
        print(to_json({"curves": path, "measured": measured}))
        return
    table(title, header, rows)
    say(f"wrote {path}, config.json, report.html, loops.png; next: activesuit identify {path}")


def _pairs(path: Path, joint: str) -> tuple[tuple[float, float], ...]:
    """Returns times [s] and angles [rad] of a file."""
    found = load_motion(path, joint)
    if found.time is None:
        raise InputError(f"{path} has no column time_s: add it, since the rig needs the rates")
    return tuple(zip(found.time.tolist(), found.angle.tolist(), strict=True))


def _kept_out(turns: Sequence[float], predict: Sequence[float] | None) -> list[float]:
    """Returns the turns whose curves test a fit."""
    if predict is None:
        return sorted(turns)[1:-1:2]
    listed = ", ".join(f"{turn:g}" for turn in turns)
    for turn in predict:
        if turn not in turns:
            raise InputError(f"predict has {turn:g} rad: give some of the turns, {listed} rad")
    if set(predict) == set(turns):
        raise InputError(f"predict has all turns, {listed} rad: leave some of them to be fitted")
    return list(predict)


def _answer(curves: Sequence[Curve]) -> str:
    peak = max(float(np.abs(curve.torque).max()) for curve in curves)
    kept_out = sum(curve.role == "predict" for curve in curves)
    return (
        f"The rig measured {len(curves)} curves, of which {kept_out} are kept out of a fit to test "
        f"it; the largest torque is {peak:.2f} N·m."
    )


def _summary(curve: Curve) -> dict[str, str | int | float]:
    return {
        "name": curve.name,
        "role": curve.role,
        "samples": curve.angle.size,
        "peak_torque": float(np.abs(curve.torque).max()),
        "work": float(np.trapezoid(curve.torque, curve.angle)),
    }
