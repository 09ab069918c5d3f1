"""Known faults of a measurement, each as the torque that it would add.

Each is one column beside the derivatives of a fit (see `identification.residual.misfit`). The
column that explains most identifies the cause, and its coefficient is the size of the fault.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.around.backlash import Backlash
from ...hysteresis.around.viscoelastic import without_rate
from ...hysteresis.protocol import HysteresisModel
from ..curves import Curve
from ..lost_motion import played, suit_angles
from ..objective import InitialTorque
from ..prediction import predicted
from ..remarks import Remark
from .misfit import Explained, explained
from .noise import GRID, Noise, whiten

RARE = 1e-4  # probability below which a fault is reported: one in thousands of fits without one
# Plays and gaps to try [rad], because the torque that they add is not proportional to them.
WIDTHS = np.radians([0.2, 1.0, 4.0])
NEVER_BELOW_ZERO = ("play", "gap")
NEGLIGIBLE = 1e-6  # least share of a column that the derivatives of the fit leave unexplained


Fault = Literal["tare", "rate", "play", "gap", "drift"]


class Cause(NamedTuple):
    """A fault that explains a part of a residual.

    Attributes:
        name: tare, rate, play, gap or drift.
        size: How large it is: [N·m] of tare, [N·m·s/rad] of rate, [rad] of play and gap, [1] of
            drift, per curve, or per cycle of one long record.
        explained: F test of its column.
        column: What a fault of size 1 adds to the torque, shape (samples,).
    """

    name: Fault
    size: float
    explained: Explained
    column: Array

    @property
    def remark(self) -> Remark:
        """The fault in words, and its remedy."""
        option = None if self.name == "rate" and self.size < 0 else _OPTIONS.get(self.name)
        return Remark(self.name, _SENTENCES[self.name](self.size), option)


_SENTENCES: dict[Fault, Callable[[float], str]] = {
    "tare": lambda size: (
        f"a torque of {size:+.2g} N·m is in all samples, whatever the angle, which the model "
        "cannot describe: zero the sensor, or fit it as the sensor's offset"
    ),
    "rate": lambda size: (
        f"the torque grows by {size:.2g} N·m with each rad/s: the joint is viscous, or the sensor "
        "lags; measure slower, or fit the rate too"
        if size > 0
        else f"the torque falls by {-size:.2g} N·m with each rad/s, which no joint shows: angle "
        "and torque are not measured at the same time; measure slower, or shift one of them"
    ),
    "play": lambda size: (
        f"the angle moves by {np.degrees(size):.2g} degrees after each reversal before the torque "
        "follows: there is play between encoder and joint; remove it, or measure the joint itself"
    ),
    "gap": lambda size: (
        f"the joint moves by about {np.degrees(size):.2g} degrees where the torque is near zero: "
        "there the contact in the transmission changes from one face to another; remove that gap, "
        "or fit it too"
    ),
    "drift": lambda size: (
        f"the torque changes by {100 * size:+.2g} % from curve to curve, or cycle to cycle: the "
        "joint wears in, or the sensor drifts; cycle the joint before, and fit only the last "
        "cycles, or remove a change that settles"
    ),
}
_OPTIONS: dict[Fault, tuple[str, str]] = {
    "tare": ("tare", "fit"),
    "rate": ("rate", "viscous"),
    "gap": ("play", "fit"),
    "drift": ("softening", "fit"),
}


def causes(
    model: HysteresisModel,
    initial_torque: InitialTorque,
    curves: Sequence[Curve],
    residual: Array,
    slopes: Array,
    known: Noise | None = None,
) -> list[Cause]:
    """Returns the faults that surely are in a residual, the most certain first.

    Args:
        model: Fitted model.
        initial_torque: Torque with which the curves begin [N·m], or "measured".
        curves: Fitted curves, in the order of measurement.
        residual: Residual of the fit [N·m], shape (samples,).
        slopes: Derivatives of the torque with respect to the fitted parameters, shape
            (samples, p).
        known: Noise known from repeated curves; None estimates it.
    """
    sizes = [curve.torque.size for curve in curves]
    found: dict[Fault, Cause] = {}
    for name, column in _columns(model, initial_torque, curves):
        if not np.isfinite(column).all():
            continue  # the model meets its pole a little beyond the curves
        rest = column - slopes @ np.linalg.lstsq(slopes, column, rcond=None)[0]
        if np.linalg.norm(rest) <= NEGLIGIBLE * np.linalg.norm(column):
            continue
        test = explained(residual, slopes, column[:, None], sizes, known)
        size = _coefficient(residual, slopes, column, sizes, test.noise)
        if test.probability >= RARE or (name in NEVER_BELOW_ZERO and size < 0):
            continue
        if name not in found or test.statistic > found[name].explained.statistic:
            found[name] = Cause(name, size, test, column)
    return sorted(found.values(), key=lambda cause: -cause.explained.statistic)


def _columns(
    model: HysteresisModel, initial_torque: InitialTorque, curves: Sequence[Curve]
) -> Iterator[tuple[Fault, Array]]:
    torque = [predicted(model, initial_torque, curve) for curve in curves]
    yield "tare", np.ones(sum(one.size for one in torque))
    timed = [(curve.angle, curve.time) for curve in curves if curve.time is not None]
    if len(timed) == len(curves):
        yield "rate", np.concatenate([np.gradient(angle, time) for angle, time in timed])
    paths: list[tuple[Fault, float, list[Array]]] = []
    for width in WIDTHS.tolist():
        paths.append(("play", width, [played(curve.angle, width) for curve in curves]))
        if not isinstance(without_rate(model), Backlash):
            paths.append(("gap", width, [suit_angles(curve, width) for curve in curves]))
    for name, width, angles in paths:
        try:
            late = [
                predicted(model, initial_torque, replace(curve, angle=angle))
                for curve, angle in zip(curves, angles, strict=True)
            ]
        except InputError:
            continue  # the model cannot begin with that torque at another angle
        yield name, (np.concatenate(late) - np.concatenate(torque)) / width
    if len(torque) > 1:
        yield "drift", np.concatenate([i * here for i, here in enumerate(torque)])
    else:
        (curve,), (here,) = curves, torque
        yield "drift", _cycles(curve.angle) * here


def _cycles(angle: Array) -> Array:
    """Returns how many cycles over its range a motion has gone through at each sample."""
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])
    return way / (2 * np.ptp(angle))


def _coefficient(
    residual: Array, slopes: Array, column: Array, sizes: Sequence[int], noise: Noise
) -> float:
    """Returns the coefficient of a column beside the slopes, under the likeliest noise."""
    memory, white = GRID[int(np.argmax(noise.weight))]
    both, _ = whiten(np.column_stack([slopes, column, residual]), sizes, memory, white)
    return float(np.linalg.lstsq(both[:, :-1], both[:, -1], rcond=None)[0][-1])
