"""`activesuit design`: writes the motion that should be measured next."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import tyro

from ...errors import InputError
from ...files import check_target, replacing
from ...identification import Motion, load_curves, motion_coverage, nested_motion, save_motion
from ...identification.data.motions import MAX_RATE, MIN_RATE, SAMPLE_RATE
from ..options import Force, Json, optional_number
from ..writer import Report, conclude


def design(
    curves: Annotated[Path | None, tyro.conf.Positional] = None,
    /,
    range: Annotated[
        tuple[float, float] | None, optional_number("that of the curves", count=2)
    ] = None,
    min_rate: float = MIN_RATE,
    max_rate: float = MAX_RATE,
    sample_rate: float = SAMPLE_RATE,
    out: Path = Path("motion.csv"),
    force: Force = False,
    json: Json = False,
) -> None:
    """Design the next record to measure: nested reversals at varied speed.

    First-order curves do not identify loops inside loops, and curves at a single rate do not show
    whether the torque depends on the rate. The designed motion shows both; rig --motion measures
    the designed motion.

    Args:
        curves: CSV file of the measured curves, whose range of angles the motion gets.
        range: Smallest and largest angle of the motion, in place of those of the curves [rad].
        min_rate: Rate of the slowest branch [rad/s].
        max_rate: Largest rate of the joint [rad/s].
        sample_rate: Lowest number of samples in a second [Hz].
        out: New CSV file for the motion, with the columns time_s and angle_rad.
    """
    start, end = _ends(curves, range)
    check_target(out, force=force)
    found = nested_motion(start, end, min_rate=min_rate, max_rate=max_rate, sample_rate=sample_rate)
    with replacing(out, force=force) as scratch:
        save_motion(scratch, Motion(found.time, found.angle))
    result = {
        "motion": out,
        "duration": found.duration,
        "samples": found.time.size,
        "points": found.points,
        "branch_rates": found.rates,
        **asdict(motion_coverage([Motion(found.time, found.angle)])),
    }
    header = ["branch", "to [rad]", "rate [rad/s]"]
    rows = [
        [str(i), f"{point:.4g}", f"{rate:.3g}"]
        for i, (point, rate) in enumerate(zip(found.points[1:], found.rates, strict=True), start=1)
    ]
    low, high = result["range"]
    remarks = [
        f"{found.duration:.0f} s from {low:.4g} to {high:.4g} rad, {result['reversals']} reversals "
        f"up to {result['nesting']} deep, {min(found.rates):.3g} to {max(found.rates):.3g} rad/s",
        f"wrote {out}; next: activesuit rig --motion {out}, or your own rig",
    ]
    report = Report(
        heading="The next record",
        about=str(out),
        result=result,
        tables={"the next record": (header, rows)},
        answer=remarks,
    )
    conclude(report, None, json)


def _ends(curves: Path | None, range: tuple[float, float] | None) -> tuple[float, float]:
    """Returns the angle at which the motion begins, and the other end of its range [rad]."""
    if (curves is None) == (range is None):
        raise InputError("give a file of curves, or --range LOW HIGH in rad, and not both")
    if curves is None:
        assert range is not None
        low, high = range
        if not low < high:
            raise InputError(f"--range is {low:g} to {high:g} rad: give the smaller angle first")
        return low, high
    family = load_curves(curves)
    low, high = family.angle_range
    nearer = abs(family.start_angle - low) <= abs(family.start_angle - high)
    return (low, high) if nearer else (high, low)
