"""Measured torque beside the torque of models, as figures and as columns."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from ..errors import InputError
from ..plots import Band, Line, Mark, Panel, Plot
from .data.curves import Curve
from .data.parts import drawn_note, drawn_samples
from .fit import Fit
from .judging.sentences import DESCRIBES
from .judging.uncertainty import Uncertainty
from .selection import Selection

ROLES = {"fit": "fitted", "predict": "predicted"}
COLUMNS = ["joint", "curve", "role", "angle_rad", "measured_nm", "model_nm", "low_nm", "high_nm"]


class Compared(NamedTuple):
    """A measured curve beside a model, thinned for figures; all arrays have shape (samples,)."""

    curve: Curve
    angle: Array  # [rad]
    measured: Array  # torque [N·m]
    model: Array  # torque of the model [N·m]; NaN without one
    low: Array  # lower end of the torque's band [N·m]; NaN without one
    high: Array  # its upper end [N·m]
    note: str = ""  # how many samples there are, where some are left out


def compared(
    curves: Sequence[Curve],
    result: Fit | Selection | None = None,
    uncertainty: Uncertainty | None = None,
) -> list[Compared]:
    """Returns measured curves beside a model; without a result, the curves alone.

    The band is that over kinds of model if they were compared; otherwise that of the parameters if
    the model describes the curves and their uncertainty is given.
    """
    found = []
    for role in ROLES:
        here = [curve for curve in curves if curve.role == role]
        note = drawn_note(here)
        for curve, drawn in zip(here, drawn_samples(here), strict=True):
            none = np.full(curve.angle.size, np.nan)
            fit = result.fit if isinstance(result, Selection) else result
            model = none if fit is None else fit.predict(curve)
            band = (none, none) if fit is None else _band(result, fit, uncertainty, curve)
            columns = (curve.angle, curve.torque, model, *(band or (none, none)))
            angle, measured, modeled, low, high = (one[drawn] for one in columns)
            found.append(Compared(curve, angle, measured, modeled, low, high, note))
    return found


def _band(
    result: Fit | Selection | None, fit: Fit, uncertainty: Uncertainty | None, curve: Curve
) -> tuple[Array, Array] | None:
    try:
        if isinstance(result, Selection) and result.ensemble is not None:
            return result.ensemble.band(curve)
        if uncertainty is not None and fit.verdict == DESCRIBES:
            return uncertainty.band(curve)
    except InputError:  # there is none along this curve
        pass
    return None


def loop_rows(joint: str, curves: Sequence[Compared]) -> Iterator[list[str]]:
    """Yields rows of `COLUMNS`; a cell without a number is empty."""
    for one in curves:
        for values in zip(one.angle, one.measured, one.model, one.low, one.high, strict=True):
            cells = (f"{value:.6g}" if np.isfinite(value) else "" for value in values)
            yield [joint, one.curve.name, one.curve.role, *cells]


def loops_plot(joint: str, fits: Mapping[str, Sequence[Compared]], tare: float = 0.0) -> Plot:
    """Returns the measured loops of a joint with the torque of each model, above the residuals.

    Fitted curves are on the left, predicted ones on the right. The same curves are beside each
    model, by its label; `tare` is the torque of the sensor that is taken off them [N·m].
    """
    first = next(iter(fits.values()))
    roles = [role for role in ROLES if any(one.curve.role == role for one in first)]
    fitted = any(np.isfinite(one.model).any() for one in first)
    torque = f"resistance [N·m]{f', {tare:.3g} N·m of the sensor taken off' if tare else ''}"
    loops, residuals = [], []
    for role in roles:
        here = {label: [x for x in ones if x.curve.role == role] for label, ones in fits.items()}
        drawn = next(iter(here.values()))
        note = f" ({drawn[0].note})" if drawn[0].note else ""
        one_color = "" if fitted else None  # without a model each curve has its color
        marks: list[Mark] = [
            Line(x.angle, x.measured, "measured" if one_color == "" else x.curve.name, points=True)
            for x in drawn
        ]
        left: list[Mark] = []
        for label, ones in here.items() if fitted else ():
            known = [x for x in ones if np.isfinite(x.low).any()]
            marks += [Band(x.angle, x.low, x.high, label) for x in known]
            marks += [Line(x.angle, x.model, label) for x in ones]
            left += [
                Line(x.angle[way], (x.measured - x.model)[way], name, points=True)
                for x in ones
                for name, way in _branches(x.angle, label if len(fits) > 1 else "").items()
            ]
        title = f"{joint.replace('_', ' ')}, {ROLES[role]}"
        loops.append(Panel(x=f"angle [rad]{note}", y=torque, marks=marks, title=title))
        zero = {"": 0.0}
        residuals.append(
            Panel(x="angle [rad]", y="measured less model [N·m]", marks=left, levels=zero)
        )
    panels = [*loops, *residuals] if fitted else loops
    title = f"Loops of the {joint.replace('_', ' ')}"
    return Plot(title=title, panels=panels, columns=len(roles))


def _branches(angle: Array, label: str) -> dict[str, NDArray[np.bool_]]:
    """Returns which samples are on ascending and which on descending branches, by name."""
    if label:
        return {label: np.ones(angle.size, bool)}
    up = np.gradient(angle) >= 0
    return {"residual, ascending": up, "residual, descending": ~up}


def convergence_plot(histories: Mapping[str, Mapping[str, Sequence[Sequence[float]]]]) -> Plot:
    """Returns the best fitness over iterations: median of the trials, and their quartiles.

    There is one history per trial, by joint and method.
    """
    panels = []
    for joint, methods in histories.items():
        marks: list[Mark] = []
        for label, runs in methods.items():
            low, middle, high = np.percentile(np.array(runs), [25, 50, 75], axis=0)
            iteration = np.arange(middle.size)
            marks += [Band(iteration, low, high, label), Line(iteration, middle, label)]
        panels.append(
            Panel(
                title=joint.replace("_", " "),
                x="iteration",
                y="fitness, eq. (7): median and quartiles",
                marks=marks,
                logarithmic=True,
            )
        )
    return Plot(title="How the swarms converge", panels=panels, columns=len(panels))
