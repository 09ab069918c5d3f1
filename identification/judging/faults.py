"""Known faults of a measurement, each as the torque that the fault would add."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ...arrays import Array
from ...hysteresis.around import Backlash, Viscoelastic, without_rate
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves
from ..fits.objective import InitialTorque, predicted

# Plays and gaps to try [rad], as their torque is not proportional to their size.
WIDTHS = np.radians([0.2, 1.0, 4.0])
REST = 3600.0  # s, so long that the way to a face has no rate
LARGEST_DRIFT = 0.5  # share of the torque from curve to curve; more is no drift
LEAST_CYCLES = 1.5  # a shorter record shows no drift
# Paces of softening to try, as numbers of curves or cycles, and the least number that shows it.
PACES = np.geomspace(0.5, 8, 12)
LEAST_WEAR = 2.0
Fault = Literal["tare", "rate", "lag", "play", "gap", "drift", "softening", "offset", "gain"]
Faulty = Callable[[HysteresisModel, InitialTorque, float], Array]


def played(angle: Array, gap: float) -> Array:
    """Returns the angle behind a play [rad], which moves only after the gap is closed."""
    found, here = np.empty_like(angle), angle[0]
    for i, ahead in enumerate(angle):
        here = min(max(here, ahead - gap), ahead)
        found[i] = here
    return found


class Hypothesis(NamedTuple):
    """A fault to try."""

    name: Fault
    curve: str  # that has the fault; empty if all have
    step: float  # size at which its column is computed
    most: float  # largest size that is plausible
    torque: Faulty  # along all curves [N·m] with a fault of some size, (samples,)


def hypotheses(model: HysteresisModel, curves: Sequence[Curve]) -> Iterator[Hypothesis]:
    """Yields all faults that the curves can show."""
    peak, span = Curves(curves).peak, max(float(np.ptp(curve.angle)) for curve in curves)
    sizes = [curve.torque.size for curve in curves]

    def plain(model: HysteresisModel, start: InitialTorque) -> list[Array]:
        return [predicted(model, start, curve) for curve in curves]

    def added(column: Array) -> Faulty:
        return lambda model, start, size: np.concatenate(plain(model, start)) + size * column

    def scaled(column: Array) -> Faulty:
        return lambda model, start, size: np.concatenate(plain(model, start)) * (1 + size * column)

    def played_torque(model: HysteresisModel, start: InitialTorque, size: float) -> Array:
        late = [replace(curve, angle=played(curve.angle, max(size, 0.0))) for curve in curves]
        return np.concatenate([predicted(model, start, curve) for curve in late])

    def late_torque(model: HysteresisModel, start: InitialTorque, size: float) -> Array:
        torques = zip(times, plain(model, start), strict=True)
        return np.concatenate([_delayed(time, torque, size) for time, torque in torques])

    def gap_torque(face: int) -> Faulty:
        def torque(model: HysteresisModel, start: InitialTorque, size: float) -> Array:
            if size <= 0:
                return np.concatenate(plain(model, start))
            behind = _behind_gap(model, size)
            begun = [_begun_at_face(curve, face * size / 2) for curve in curves]
            return np.concatenate([predicted(behind, start, curve)[1:] for curve in begun])

        return torque

    yield Hypothesis("tare", "", peak, peak / 2, added(np.ones(sum(sizes))))
    times = [curve.time for curve in curves if curve.time is not None]
    if len(times) == len(curves):
        pairs = zip(curves, times, strict=True)
        rate = np.concatenate([np.gradient(curve.angle, time) for curve, time in pairs])
        most = peak / max(float(np.abs(rate).max()), np.finfo(float).tiny)
        yield Hypothesis("rate", "", most, most, added(rate))
        step = float(np.median(np.concatenate([np.diff(time) for time in times])))
        shortest = min(float(np.ptp(time)) for time in times)
        yield Hypothesis("lag", "", step, shortest / 4, late_torque)
    way = curves[0].angle - curves[0].angle[0]
    ahead = 1 if way.max() > -way.min() else -1
    for width in WIDTHS.tolist():
        yield Hypothesis("play", "", width, span / 4, played_torque)
        if not isinstance(without_rate(model), Backlash):
            for face in (0, ahead):  # the motion begins in the middle of the gap, or in contact
                yield Hypothesis("gap", "", width, span / 4, gap_torque(face))
    order = np.repeat(np.arange(len(curves), dtype=np.float64), sizes)
    passed = order if len(curves) > 1 else _cycles(curves[0].angle)
    if len(curves) > 1 or passed[-1] >= LEAST_CYCLES:
        yield Hypothesis("drift", "", 1.0, LARGEST_DRIFT, scaled(passed))
    for pace in PACES.tolist() if passed[-1] >= LEAST_WEAR else ():
        yield Hypothesis("softening", "", 1.0, LARGEST_DRIFT, scaled(np.exp(-passed / pace)))
    for i, curve in enumerate(curves if len(curves) > 1 else ()):
        here = np.where(order == i, 1.0, 0.0)
        yield Hypothesis("offset", curve.name, peak, peak / 2, added(here))
        yield Hypothesis("gain", curve.name, 1.0, np.inf, scaled(here))


def _delayed(time: Array, torque: Array, lag: float) -> Array:
    """Returns the torques a lag [s] earlier: constant before the curve, linear after it."""
    last = (torque[-1] - torque[-2]) / (time[-1] - time[-2])
    beyond = np.maximum(time - lag - time[-1], 0.0)
    return np.interp(time - lag, time, torque) + last * beyond


def _begun_at_face(curve: Curve, shift: float) -> Curve:
    """Returns a curve that has moved through a part of a gap before its first sample [rad]."""
    time = curve.time
    if time is not None:
        time = np.concatenate([time[:1] - REST, time])
    return replace(
        curve,
        angle=np.concatenate([curve.angle[:1], curve.angle + shift]),
        torque=np.concatenate([curve.torque[:1], curve.torque]),
        time=time,
    )


def _behind_gap(model: HysteresisModel, gap: float) -> HysteresisModel:
    """Returns a model behind a gap; a dashpot stays beside both."""
    if isinstance(model, Viscoelastic):
        return replace(model, model=_behind_gap(model.model, gap))
    return Backlash(model=model, gap=gap)


def _cycles(angle: Array) -> Array:
    """Returns how many cycles over its range a motion has gone through at each sample."""
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(angle)))])
    return way / (2 * np.ptp(angle))
