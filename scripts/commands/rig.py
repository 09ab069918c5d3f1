"""`activesuit rig`: measures a simulated suit joint as the paper measured a real joint."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import numpy as np

from ...envs.rig import RigConfig, run_rig
from ...envs.rig.rig import NOISE, RATE, SAMPLE_RATE
from ...errors import InputError
from ...identification import Curve, load_motion, save_curves
from ...identification.figures import compared, loops_plot
from ..folders import RunFolder
from ..options import Force, Json, Seed, SuitName, choice, joints
from ..writer import Report, conclude


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
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Measure first-order curves of a suit joint on a simulated rig.

    Args:
        joint: Joint of the suit that is measured.
        motion: CSV file of a motion that is measured in place of first-order curves, with the
            columns time_s and angle_rad, as `activesuit design` writes it. The motor goes from
            reversal to reversal at the mean rate of each branch, from 0.01 to 0.5 rad/s.
        turns: Angles at which the curves turn back [rad]; by default the angles of the paper for
            shoulder and elbow, and fifths of the range for other joints.
        predict: Turns [rad] whose curves are kept out of a fit, to test the model; by default the
            second, the fourth, ... but not the last.
        start_angle: Angle at which the curves begin and end [rad]; by default the start angle of
            the joint in the suit.
        repeats: Number of times that each curve goes to its turn and back.
        rate: Speed of the joint [rad/s], from 0.01 to 0.5.
        sample_rate: Sampling rate of the sensors [Hz], from 1 to 1000.
        noise: Standard deviation of the torque sensor's noise [N·m].
        drift: Drift of the torque sensor since the beginning of a curve [N·m/s].
        torque_resolution: Step of the torque sensor [N·m]; by default there are no steps.
        angle_resolution: Step of the encoder [rad]; by default there are no steps.
        bearing_friction: Friction of the bearings [N·m].
        out: Folder for the curves (JOINT.csv), result.json, report.html and the loops as PNG and
            SVG: a new or an empty folder.
    """
    pairs: tuple[tuple[float, float], ...] = ()
    if motion:
        found = load_motion(motion, joint)
        if found.time is None:
            raise InputError(
                f"{motion} has no column time_s: add it, since the rig needs the rates"
            )
        pairs = tuple(zip(found.time.tolist(), found.angle.tolist(), strict=True))
    device = {"rate": rate, "sample_rate": sample_rate, "noise": noise, "drift": drift}
    device |= {"torque_resolution": torque_resolution, "angle_resolution": angle_resolution}
    config = RigConfig(
        **{"suit": suit, "joint": joint, "turns": turns, "start_angle": start_angle},
        **{"repeats": repeats, "bearing_friction": bearing_friction, "seed": seed},
        **{"motion": pairs, **device},
    )
    if motion and predict is not None:
        raise InputError("--predict belongs to first-order curves: leave it out beside --motion")
    kept_out = _kept_out(config.turns, predict)
    folder = RunFolder.of(out, "rig", force=force)
    names = {f"{turn:.2f}" for turn in kept_out}
    curves = [
        Curve(x.angle, x.torque, x.name, "predict" if x.name in names else "fit", time=x.time)
        for x in run_rig(config)
    ]
    path, title = folder / f"{joint}.csv", f"{suit}, {joint.replace('_', ' ')}"
    save_curves(path, curves, comments=(f"Measured on the simulated rig: {title}.",))
    measured = [
        {
            **{"name": curve.name, "role": curve.role, "samples": curve.angle.size},
            "peak_torque": float(np.abs(curve.torque).max()),
            "work": float(np.trapezoid(curve.torque, curve.angle)),
        }
        for curve in curves
    ]
    header = ["curve", "role", "samples", "peak torque\n[N·m]", "work\n[J]"]
    rows = [[f"{v:z.3f}" if isinstance(v, float) else str(v) for v in m.values()] for m in measured]
    settings = {**asdict(config), "predict": kept_out}
    answer = (
        f"The rig measured {len(curves)} curves, of which "
        f"{sum(curve.role == 'predict' for curve in curves)} are kept out of a fit to test it; the "
        f"largest torque is {max(one['peak_torque'] for one in measured):.2f} N·m."
    )
    report = Report(
        heading="Measured on the simulated rig",
        about=title,
        result={"curves": path, "measured": measured, "config": settings},
        tables={title: (header, rows)},
        answer=[answer, f"next: activesuit identify {path}"],
        plots={"loops": loops_plot(joint, {"": compared(curves)})},
        settings=settings,
    )
    conclude(report, folder, json)


def _kept_out(turns: Sequence[float], predict: Sequence[float] | None) -> list[float]:
    """Returns the turns of the curves that are kept out of a fit."""
    if predict is None:
        return sorted(turns)[1:-1:2]
    listed = ", ".join(f"{turn:g}" for turn in turns)
    for turn in predict:
        if turn not in turns:
            raise InputError(f"predict has {turn:g} rad: give some of the turns, {listed} rad")
    if set(predict) == set(turns):
        raise InputError(f"predict has all turns, {listed} rad: leave some of them to be fitted")
    return list(predict)
