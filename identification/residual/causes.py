"""Known faults of a measurement, each as the torque that it would add.

Each fault is first one column beside the derivatives of a fit (see `residual.misfit`). Those that
the F test finds are then fitted beside the model, alone or in pairs, and are causes only if nothing
but noise remains: a wrong model is no fault of the measurement, and no fault makes it right.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.around.backlash import Backlash
from ...hysteresis.around.viscoelastic import Viscoelastic, without_rate
from ...hysteresis.protocol import HysteresisModel
from ..curves import Curve, Curves
from ..lost_motion import played
from ..objective import InitialTorque
from ..prediction import predicted
from ..remarks import Remark
from .misfit import Explained, explained
from .noise import GRID, Noise, whiten
from .tangent import Coordinates

RARE = 1e-4  # probability below which a fault is certain: one in thousands of fits without one
ENOUGH = 0.005  # probability of the rest by noise alone, from which on nothing but noise remains
# Probability below which a fault is fitted. Play and gaps are less certain by their column, which
# has another size than they, than by their fit.
SCREENED = 0.005
# Plays and gaps to try [rad], because the torque that they add is not proportional to them.
WIDTHS = np.radians([0.2, 1.0, 4.0])
# Where in a gap the motion begins: at the face that pushes upwards, between both, at the other one.
FACES = (1, 0, -1)
REST = 3600.0  # s, so long that the way to that face has no rate
NEVER_BELOW_ZERO = ("play", "gap", "rate")
NEGLIGIBLE = 1e-6  # least share of a column that the derivatives of the fit leave unexplained
TRIED = 4  # number of faults that are fitted, of those with the largest F
SECOND = 2  # number of faults that are fitted beside each of them
FEW = 12  # coordinates of a model, up to which a fault is fitted beside it anew
STEPS = 40  # largest number of steps of such a fit
LARGEST_DRIFT = 0.5  # share of the torque from curve to curve; more is no drift
LEAST_CYCLES = 1.5  # a shorter record shows no drift
# Paces of wear-in to try, as numbers of curves or cycles, and least number that shows it.
PACES = np.geomspace(0.5, 8, 12)
LEAST_WEAR = 2.0


Fault = Literal["tare", "rate", "lag", "play", "gap", "drift", "softening", "offset", "gain"]
Faulty = Callable[[HysteresisModel, InitialTorque, float], Array]


class Hypothesis(NamedTuple):
    """A fault to try.

    Attributes:
        name: Name of the fault.
        curve: Curve that has it; empty if all have.
        step: Size at which its column is computed.
        most: Largest size that is plausible.
        torque: Torque along all curves [N·m] with a fault of some size, shape (samples,).
    """

    name: Fault
    curve: str
    step: float
    most: float
    torque: Faulty


@dataclass(frozen=True, eq=False)
class Cause:
    """A fault that, alone or with another one, explains a residual down to the noise.

    Attributes:
        name: tare, rate, lag, play, gap, drift, softening, offset or gain.
        curve: Name of the curve that has it; empty if all have.
        size: How large it is: [N·m] of tare and offset, [N·m·s/rad] of rate, [s] of lag, [rad] of
            play and gap, [1] of gain, of drift, per curve, or per cycle of one long record, and of
            softening, at the beginning over the end.
        explained: F test of its column.
        left: Root mean square of the residual if all of them are fitted too [N·m].
    """

    name: Fault
    curve: str
    size: float
    explained: Explained
    left: float

    @property
    def remark(self) -> Remark:
        """The fault in words, and its remedy."""
        sentence = _SENTENCES[self.name](self.size, self.curve)
        return Remark(self.name, sentence, _OPTIONS.get(self.name))


_SENTENCES: dict[Fault, Callable[[float, str], str]] = {
    "tare": lambda size, _: (
        f"a torque of {size:+.2g} N·m is in all samples, whatever the angle, which the model "
        "cannot describe: zero the sensor, or fit it as the sensor's offset"
    ),
    "rate": lambda size, _: (
        f"the torque grows by {size:.2g} N·m with each rad/s: the joint is viscous; measure "
        "slower, or fit the rate too"
    ),
    "lag": lambda size, _: (
        f"the torque is measured {abs(size):.2g} s {'after' if size > 0 else 'before'} the angle: "
        "shift one of them, use the same filter for both, or measure slower"
    ),
    "play": lambda size, _: (
        f"the angle moves by {np.degrees(size):.2g} degrees after each reversal before the torque "
        "follows: there is play between encoder and joint; remove it, or measure the joint itself"
    ),
    "gap": lambda size, _: (
        f"the joint moves by about {np.degrees(size):.2g} degrees where the torque is near zero: "
        "there the contact in the transmission changes from one face to another; remove that gap, "
        "or fit it too"
    ),
    "drift": lambda size, _: (
        f"the torque changes by {100 * size:+.2g} % from curve to curve, or cycle to cycle: the "
        "sensor drifts, or the joint wears; measure in one go, or remove the change"
    ),
    "softening": lambda size, _: (
        f"the torque begins {100 * abs(size):.2g} % {'larger' if size > 0 else 'smaller'} than it "
        "ends: the joint wears in; cycle it before, and fit only the last cycles, or remove the "
        "change"
    ),
    "offset": lambda size, curve: (
        f"a torque of {size:+.2g} N·m is in all samples of curve {curve!r}, and not in the others: "
        "zero the sensor before every curve; subtract it there, or measure that curve again"
    ),
    "gain": lambda size, curve: (
        f"the torque of curve {curve!r} is {100 * size:+.2g} % larger than that of the others: "
        "check the sensor's range and the unit of that curve, or measure it again"
    ),
}
_OPTIONS: dict[Fault, tuple[str, str]] = {
    "tare": ("tare", "fit"),
    "rate": ("rate", "viscous"),
    "gap": ("play", "fit"),
    **dict.fromkeys(("drift", "softening"), ("softening", "fit")),
}


class Linear(NamedTuple):
    """A fault as one column beside the derivatives of a fit.

    Attributes:
        hypothesis: The fault.
        column: What a fault of size 1 adds to the torque, shape (samples,).
        size: Its coefficient.
        explained: F test of the column.
    """

    hypothesis: Hypothesis
    column: Array
    size: float
    explained: Explained


class Beside(NamedTuple):
    """A model and faults that are fitted together.

    Attributes:
        residual: What remains [N·m], shape (samples,).
        slopes: Derivatives of the torque with respect to the model's coordinates and to the sizes
            of the faults, shape (samples, p + faults).
        sizes: Size of each fault.
        added: Torque that each fault adds [N·m], shape (samples, faults).
    """

    residual: Array
    slopes: Array
    sizes: Array
    added: Array


def causes(
    coordinates: Coordinates,
    curves: Sequence[Curve],
    residual: Array,
    slopes: Array,
    smooth: Array,
    scale: Array,
    known: Noise | None = None,
) -> list[Cause]:
    """Returns the fault, or the two, that explain a residual down to the noise.

    Residual, slopes and smooth columns are divided by the relative deviation of the noise.

    Args:
        coordinates: Fitted model and initial torque.
        curves: Fitted curves, in the order of measurement.
        residual: Residual of the fit [N·m], shape (samples,).
        slopes: Derivatives of the torque with respect to the fitted parameters, shape
            (samples, p).
        smooth: Columns that may explain what remains, shape (samples, q).
        scale: Relative deviation of the noise of each sample, shape (samples,).
        known: Noise known from repeated curves; None estimates it.
    """
    model, start = coordinates.at(coordinates.point)
    columns = [(one, column / scale) for one, column in _columns(model, start, curves)]
    lengths = [curve.torque.size for curve in curves]

    nothing = Beside(residual, slopes, np.empty(0), np.empty((residual.size, 0)))
    alone = _likely(columns, nothing, lengths, known, below=SCREENED)
    pairs = []
    for groups in ([(one,) for one in alone], pairs):
        right = []
        for faults in groups:
            fit = _fitted(coordinates, curves, residual, slopes, scale, faults)
            if fit is None:
                continue
            if explained(fit.residual, fit.slopes, smooth, lengths, known).probability >= ENOUGH:
                proofs = _proofs(fit, faults, lengths, known)
                if all(one.probability < RARE for one in proofs):
                    right.append((faults, fit, proofs))
            elif len(faults) == 1 and faults[0].explained.probability < RARE:
                others = _likely(
                    columns, fit, lengths, known, below=RARE, but=faults[0].hypothesis.name
                )
                pairs += [(*faults, other) for other in others[:SECOND]]
        if right:
            faults, fit, proofs = min(right, key=lambda some: _criterion(*some[:2]))
            left = float(np.sqrt(np.mean(fit.residual**2)))
            return [
                Cause(one.hypothesis.name, one.hypothesis.curve, size, proof, left)
                for one, size, proof in zip(faults, fit.sizes.tolist(), proofs, strict=True)
            ]
    return []


def _proofs(
    fit: Beside, faults: Sequence[Linear], lengths: Sequence[int], known: Noise | None
) -> list[Explained]:
    """Returns the surer F test of each fault: by its column, or by what it adds at its size."""
    first, found = fit.slopes.shape[1] - fit.sizes.size, []
    for i, (one, added) in enumerate(zip(faults, fit.added.T, strict=True)):
        others = np.delete(fit.slopes, first + i, axis=1)
        test = _surest(fit.residual + added, others, added, lengths, known)
        found.append(min(test, one.explained, key=lambda some: some.probability))
    return found


def _surest(
    residual: Array, slopes: Array, column: Array, lengths: Sequence[int], known: Noise | None
) -> Explained:
    """Returns the F test of a column under the noise of repeats or of the residual.

    One pair of repeats says little of slow noise, and so would make few faults certain.
    """
    noises = (known, None) if known else (None,)
    tests = [explained(residual, slopes, column[:, None], lengths, one) for one in noises]
    return min(tests, key=lambda one: one.probability)


def _criterion(faults: Sequence[Linear], fit: Beside) -> float:
    """Returns the Bayesian information criterion of faults that are fitted beside a model.

    Wear-in has a pace, too, which is chosen among several.
    """
    numbers = sum(2 if one.hypothesis.name == "softening" else 1 for one in faults)
    samples = fit.residual.size
    return samples * math.log(float(fit.residual @ fit.residual)) + numbers * math.log(samples)


def _columns(
    model: HysteresisModel, start: InitialTorque, curves: Sequence[Curve]
) -> Iterator[tuple[Hypothesis, Array]]:
    """Yields all faults that the curves can show, each with its column."""
    for hypothesis in _hypotheses(model, curves):
        try:
            here = hypothesis.torque(model, start, 0.0)
            column = (hypothesis.torque(model, start, hypothesis.step) - here) / hypothesis.step
        except InputError:
            continue  # the model cannot begin with that torque at another angle
        if np.isfinite(column).all():  # else the model meets its pole a little beyond the curves
            yield hypothesis, column


def _likely(
    columns: Sequence[tuple[Hypothesis, Array]],
    fit: Beside,
    lengths: Sequence[int],
    known: Noise | None,
    *,
    below: float,
    but: str = "",
) -> list[Linear]:
    """Returns the faults of a probability below some limit, the likeliest first, but for one."""
    found: dict[Fault, Linear] = {}
    residual, slopes = fit.residual, fit.slopes
    for hypothesis, column in columns:
        if hypothesis.name == but:
            continue
        rest = column - slopes @ np.linalg.lstsq(slopes, column, rcond=None)[0]
        if np.linalg.norm(rest) <= NEGLIGIBLE * np.linalg.norm(column):
            continue
        test = _surest(residual, slopes, column, lengths, known)
        size = _coefficient(residual, slopes, column, lengths, test.noise)
        if test.probability >= below or (hypothesis.name in NEVER_BELOW_ZERO and size < 0):
            continue
        best = found.get(hypothesis.name)
        if best is None or test.statistic > best.explained.statistic:
            found[hypothesis.name] = Linear(hypothesis, column, size, test)
    return sorted(found.values(), key=lambda one: -one.explained.statistic)[:TRIED]


def _fitted(
    coordinates: Coordinates,
    curves: Sequence[Curve],
    residual: Array,
    slopes: Array,
    scale: Array,
    faults: Sequence[Linear],
) -> Beside | None:
    """Returns faults that are fitted beside the model; None if one is not plausible."""
    if coordinates.point.size <= FEW:
        found = _anew(coordinates, curves, scale, faults)
    else:
        both = np.column_stack([slopes, *(one.column for one in faults)])
        best: Array = np.asarray(np.linalg.lstsq(both, residual, rcond=None)[0], dtype=np.float64)
        sizes = best[slopes.shape[1] :]
        found = Beside(residual - both @ best, both, sizes, both[:, slopes.shape[1] :] * sizes)
    if found is None:
        return None
    for one, size in zip(faults, found.sizes.tolist(), strict=True):
        if abs(size) > one.hypothesis.most or (
            one.hypothesis.name in NEVER_BELOW_ZERO and size <= 0
        ):
            return None
    return found


def _anew(
    coordinates: Coordinates, curves: Sequence[Curve], scale: Array, faults: Sequence[Linear]
) -> Beside | None:
    """Fits model and faults together by least squares; None where that fails."""
    from scipy.optimize import least_squares  # slow to import

    measured = np.concatenate([curve.torque for curve in curves])
    count = coordinates.point.size
    far = 10 * np.abs(measured).max()

    def residual(at: Array) -> Array:
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                return ahead(at)
        except (InputError, OverflowError):
            return np.full(measured.size, far)

    def ahead(at: Array) -> Array:
        plain, added = parts(at)
        left = (measured - plain) / scale - added.sum(axis=1)
        return np.clip(np.where(np.isfinite(left), left, far), -far, far)  # a pole is near

    def parts(at: Array) -> tuple[Array, Array]:
        model, start = coordinates.at(at[:count])
        plain = np.concatenate([predicted(model, start, curve) for curve in curves])
        pairs = zip(faults, at[count:].tolist(), strict=True)
        added = [one.hypothesis.torque(model, start, size) - plain for one, size in pairs]
        return plain, np.column_stack(added) / scale[:, None]

    begin = np.concatenate([coordinates.point, [one.size for one in faults]])
    found = least_squares(residual, begin, x_scale="jac", max_nfev=STEPS)
    if not np.isfinite(found.fun).all() or not np.isfinite(found.jac).all():
        return None
    return Beside(found.fun, -found.jac, found.x[count:], parts(found.x)[1])


def _hypotheses(model: HysteresisModel, curves: Sequence[Curve]) -> Iterator[Hypothesis]:
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
    for width in WIDTHS.tolist():
        yield Hypothesis("play", "", width, span / 4, played_torque)
        if not isinstance(without_rate(model), Backlash):
            for face in FACES:
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
    """Returns torques of an earlier time; the joint rests before the first, and goes on at last."""
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
    """Returns a model behind a gap; a dashpot stays beside it."""
    if isinstance(model, Viscoelastic):
        return replace(model, model=_behind_gap(model.model, gap))
    return Backlash(model=model, gap=gap)


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
