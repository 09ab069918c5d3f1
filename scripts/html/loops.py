"""Measured torque-angle loops beside those of a model: kept as CSV, drawn as charts."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...identification import Curve, Fit, Selection
from ...identification.residual.verdict import DESCRIBES
from ...identification.thinning import drawn_samples
from ...identification.uncertainty.uncertainty import Uncertainty
from ..folders import RunFolder
from .blocks import Chart
from .charts import COLORS, Figure, band, line, plain, points
from .series import read_columns

FILE = "loops.csv"
NUMBERS = ("angle_rad", "measured_nm", "model_nm", "low_nm", "high_nm")
HEADER = ("joint", "curve", "role", *NUMBERS)
ROLES = {"fit": "fitted", "predict": "held out of the fit"}


class Drawn(NamedTuple):
    """A curve of loops.csv: names, then angle [rad] and torques [N·m]; NaN where there is none."""

    joint: str
    curve: str
    role: str
    angle: Array
    measured: Array
    model: Array
    low: Array
    high: Array


def loop_rows(
    joint: str, result: Fit | Selection, found: Uncertainty | None
) -> Iterator[list[str]]:
    """Yields rows of loops.csv: measured torque, torque of the model, and the ends of its band.

    The band is that over kinds of model where they were compared, else that of the parameters where
    the model holds beyond the curves. A long record is thinned as in the other figures.

    Args:
        joint: Name of the joint.
        result: Fit of the joint.
        found: Uncertainty of its parameters; None if it was not asked for.
    """
    fit = result.fit if isinstance(result, Selection) else result
    for role in ROLES:
        curves = [curve for curve in fit.curves if curve.role == role]
        for curve, drawn in zip(curves, drawn_samples(curves), strict=True):
            low, high = _band(result, found, curve)
            columns = (curve.angle, curve.torque, fit.predict(curve), low, high)
            for values in zip(*(column[drawn] for column in columns), strict=True):
                yield [joint, curve.name, role, *map(_cell, values)]


def write_loops(folder: RunFolder, rows: Iterator[list[str]]) -> None:
    """Writes loops.csv."""
    folder.csv(FILE, HEADER, rows)


def measured_rows(joint: str, curves: list[Curve]) -> Iterator[list[str]]:
    """Yields rows of loops.csv without a model."""
    for curve, drawn in zip(curves, drawn_samples(curves), strict=True):
        for angle, torque in zip(curve.angle[drawn], curve.torque[drawn], strict=True):
            yield [joint, curve.name, curve.role, _cell(angle), _cell(torque), "", "", ""]


def loop_charts(folder: Path) -> Iterator[Chart]:
    """Yields charts of each joint: fitted and held-out loops, and what the model leaves."""
    curves = _read(folder)
    for joint in dict.fromkeys(one.joint for one in curves):
        here = [one for one in curves if one.joint == joint]
        for role, meaning in ROLES.items():
            if shown := [one for one in here if one.role == role]:
                yield _loops(joint, meaning, shown)
        if any(np.isfinite(one.model).any() for one in here):
            yield _residuals(joint, here)


def _read(folder: Path) -> list[Drawn]:
    texts, numbers = read_columns(folder, FILE, ("joint", "curve", "role"), NUMBERS)
    names = list(zip(*(texts[name] for name in ("joint", "curve", "role")), strict=True))
    found = []
    for key in dict.fromkeys(names):
        rows = np.array([name == key for name in names])
        found.append(Drawn(*key, *(numbers[name][rows] for name in NUMBERS)))
    return found


def _loops(joint: str, meaning: str, curves: list[Drawn]) -> Chart:
    name = joint.replace("_", " ")
    data: list[Figure] = []
    for one, color in zip(curves, COLORS * len(curves), strict=False):
        if np.isfinite(one.low).any():
            data.append(
                band(
                    *(one.angle, one.low, one.high, f"band, {one.curve}", color),
                    group=one.curve,
                    legend=True,
                )
            )
        data.append(
            points(one.angle, one.measured, f"measured, {one.curve}", color, group=one.curve)
        )
        if np.isfinite(one.model).any():
            data.append(line(one.angle, one.model, f"model, {one.curve}", color, group=one.curve))
    return Chart(
        title=f"{name}: loops {meaning}",
        text=f"Torque over angle of the {name}: {len(curves)} curves {meaning}, as points, and the "
        "torque of the model as lines.",
        data=data,
        layout=plain("angle [rad]", "resistance [N·m]", 480),
    )


def _residuals(joint: str, curves: list[Drawn]) -> Chart:
    name = joint.replace("_", " ")
    data = [
        line(
            one.angle,
            one.measured - one.model,
            f"{one.curve} ({ROLES.get(one.role, one.role)})",
            color,
            dash="solid" if one.role == "fit" else "dot",
            width=1.1,
        )
        for one, color in zip(curves, COLORS * len(curves), strict=False)
    ]
    return Chart(
        title=f"{name}: measured less modeled torque",
        text=f"What the model leaves of the measured torque of the {name}, over angle.",
        data=data,
        layout=plain("angle [rad]", "residual [N·m]", 320),
    )


def _band(result: Fit | Selection, found: Uncertainty | None, curve: Curve) -> tuple[Array, Array]:
    none = np.full(curve.angle.size, np.nan)
    try:
        if isinstance(result, Selection) and result.ensemble is not None:
            return result.ensemble.band(curve)
        fit = result.fit if isinstance(result, Selection) else result
        if found is not None and fit.verdict == DESCRIBES:
            return found.band(curve)
    except InputError:  # there is none along this curve
        pass
    return none, none


def _cell(value: float) -> str:
    return f"{value:.6g}" if np.isfinite(value) else ""
