"""Faults of a measurement that explain the residual of a fit: their tests, fits and choice.

Each of `judging.faults` is first one column beside the derivatives of a fit (see
`judging.misfit`). The faults that the F test finds are then fitted beside the model, alone or in
pairs, and are causes only if nothing but noise remains: then the model is right.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ..data.curves import Curves
from ..fits.objective import predicted
from ..fits.tangent import Coordinates
from .faults import Fault, Hypothesis, hypotheses
from .misfit import Explained, explained
from .noise import GRID, Noise, whiten
from .sentences import Remark

RARE = 1e-4  # probability below which a fault counts as certain
ENOUGH = 0.005  # probability of the rest by noise alone, from which on nothing but noise remains
# Probability below which a fault is fitted: more than RARE, because the column of a play or gap is
# computed at another size than that of the fit.
SCREENED = 0.005
NEVER_BELOW_ZERO = ("play", "gap", "rate")
NEGLIGIBLE = 1e-6  # least share of a column that the derivatives of the fit leave unexplained
TRIED = 4  # number of faults that are fitted, of those with the largest F
SECOND = 2  # number of faults that are fitted beside each of them
FEW = 12  # coordinates of a model, up to which a fault is fitted beside it anew
STEPS = 40  # largest number of steps of such a fit


@dataclass(frozen=True, eq=False)
class Cause:
    """A fault that, alone or with another one, explains a residual down to the noise.

    Attributes:
        name: tare, rate, lag, play, gap, drift, softening, offset or gain.
        curve: Name of the curve with the fault; empty if all curves have the fault.
        size: Size: [N·m] of tare and offset, [N·m·s/rad] of rate, [s] of lag, [rad] of play and
            gap, [1] of gain, of drift (per curve, or per cycle of one long record) and of softening
            (at the beginning, relative to the end).
        explained: F test of its column, or of its torque at the fitted size.
        left: Root mean square of the residual if all causes are fitted too [N·m].
    """

    name: Fault
    curve: str
    size: float
    explained: Explained
    left: float

    @property
    def remark(self) -> Remark:
        """The fault and its remedy."""
        size, percent = self.size, 100 * self.size
        values = {"size": size, "curve": self.curve, "degrees": math.degrees(size)}
        values |= {"length": abs(size), "when": "after" if size > 0 else "before"}
        values |= {"percent": percent, "change": abs(percent)}
        return Remark(self.name, values | {"more": "larger" if size > 0 else "smaller"})


class Residual(NamedTuple):
    """The residual of a fit, with the quantities of its tests.

    Residual, slopes and smooth columns are divided by the relative deviation of the noise.
    """

    coordinates: Coordinates  # of model and initial torque
    curves: Curves  # in the order of measurement
    values: Array  # measured less fitted torque [N·m], (samples,)
    slopes: Array  # of the torque by the fitted parameters, (samples, p)
    smooth: Array  # columns that may explain the residual, (samples, q)
    scale: Array  # relative deviation of the noise of each sample, (samples,)
    known: Noise | None  # from repeated curves; None: to be estimated

    @property
    def sizes(self) -> list[int]:
        """Number of samples of each curve."""
        return [curve.torque.size for curve in self.curves]


class Linear(NamedTuple):
    """A fault as one column (samples,) beside the derivatives of a fit, with its F test."""

    hypothesis: Hypothesis
    column: Array
    size: float
    explained: Explained


class Beside(NamedTuple):
    """A model and faults that are fitted together."""

    residual: Array  # residual of both [N·m], (samples,)
    slopes: Array  # of the torque by coordinates and sizes, (samples, p + faults)
    sizes: Array  # of the faults
    added: Array  # torque of each fault [N·m], (samples, faults)


def causes(rest: Residual) -> list[Cause]:
    """Returns the fault, or the two, that explain a residual down to the noise."""
    columns = [*_columns(rest)]
    nothing = Beside(rest.values, rest.slopes, np.empty(0), np.empty((rest.values.size, 0)))
    alone = _likely(rest, columns, nothing, below=SCREENED)
    pairs = []
    for groups in ([(one,) for one in alone], pairs):
        right = []
        for faults in groups:
            fit = _fitted(rest, faults)
            if fit is None:
                continue
            left = explained(fit.residual, fit.slopes, rest.smooth, rest.sizes, rest.known)
            if left.probability >= ENOUGH:
                proofs = _proofs(rest, fit, faults)
                if all(one.probability < RARE for one in proofs):
                    right.append((faults, fit, proofs))
            elif len(faults) == 1 and faults[0].explained.probability < RARE:
                name = faults[0].hypothesis.name
                others = _likely(rest, columns, fit, below=RARE, but=name)
                pairs += [(*faults, other) for other in others[:SECOND]]
        if right:
            faults, fit, proofs = min(right, key=lambda some: _criterion(*some[:2]))
            left = float(np.sqrt(np.mean(fit.residual**2)))
            return [
                Cause(one.hypothesis.name, one.hypothesis.curve, size, proof, left)
                for one, size, proof in zip(faults, fit.sizes.tolist(), proofs, strict=True)
            ]
    return []


def _proofs(rest: Residual, fit: Beside, faults: Sequence[Linear]) -> list[Explained]:
    """Returns the surer F test of each fault: of its column, or of its torque at its size."""
    first, found = fit.slopes.shape[1] - fit.sizes.size, []
    for i, (one, added) in enumerate(zip(faults, fit.added.T, strict=True)):
        others = np.delete(fit.slopes, first + i, axis=1)
        test = _surest(rest, fit.residual + added, others, added)
        found.append(min(test, one.explained, key=lambda some: some.probability))
    return found


def _surest(rest: Residual, residual: Array, slopes: Array, column: Array) -> Explained:
    """Returns the F test of a column under the noise of repeats or of the residual.

    One pair of repeats says little of slow noise, and so would make few faults certain.
    """
    noises = (rest.known, None) if rest.known else (None,)
    tests = [explained(residual, slopes, column[:, None], rest.sizes, one) for one in noises]
    return min(tests, key=lambda one: one.probability)


def _criterion(faults: Sequence[Linear], fit: Beside) -> float:
    """Returns the Bayesian information criterion of faults that are fitted beside a model.

    Softening has two parameters: its size, and its pace, which is chosen among several.
    """
    numbers = sum(2 if one.hypothesis.name == "softening" else 1 for one in faults)
    samples = fit.residual.size
    return samples * math.log(float(fit.residual @ fit.residual)) + numbers * math.log(samples)


def _columns(rest: Residual) -> Iterator[tuple[Hypothesis, Array]]:
    """Yields all faults that the curves can show, each with its column."""
    model, start = rest.coordinates.at(rest.coordinates.point)
    for one in hypotheses(model, rest.curves):
        try:
            here = one.torque(model, start, 0.0)
            column = (one.torque(model, start, one.step) - here) / one.step
        except InputError:
            continue  # the model cannot begin with that torque at another angle
        if np.isfinite(column).all():  # else the model meets its pole a little beyond the curves
            yield one, column / rest.scale


def _likely(
    rest: Residual,
    columns: Sequence[tuple[Hypothesis, Array]],
    fit: Beside,
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
        alone = column - slopes @ np.linalg.lstsq(slopes, column, rcond=None)[0]
        if np.linalg.norm(alone) <= NEGLIGIBLE * np.linalg.norm(column):
            continue
        test = _surest(rest, residual, slopes, column)
        memory, white = GRID[int(np.argmax(test.noise.weight))]
        both = np.column_stack([slopes, column, residual])
        both, _ = whiten(both, rest.sizes, memory, white)
        size = float(np.linalg.lstsq(both[:, :-1], both[:, -1], rcond=None)[0][-1])
        if test.probability >= below or (hypothesis.name in NEVER_BELOW_ZERO and size < 0):
            continue
        best = found.get(hypothesis.name)
        if best is None or test.statistic > best.explained.statistic:
            found[hypothesis.name] = Linear(hypothesis, column, size, test)
    return sorted(found.values(), key=lambda one: -one.explained.statistic)[:TRIED]


def _fitted(rest: Residual, faults: Sequence[Linear]) -> Beside | None:
    """Returns faults that are fitted beside the model; None if one is not plausible."""
    if rest.coordinates.point.size <= FEW:
        found = _anew(rest, faults)
    else:
        count = rest.slopes.shape[1]
        both = np.column_stack([rest.slopes, *(one.column for one in faults)])
        best: Array = np.asarray(np.linalg.lstsq(both, rest.values, rcond=None)[0], np.float64)
        sizes = best[count:]
        found = Beside(rest.values - both @ best, both, sizes, both[:, count:] * sizes)
    if found is None:
        return None
    for one, size in zip(faults, found.sizes.tolist(), strict=True):
        if abs(size) > one.hypothesis.most or (
            one.hypothesis.name in NEVER_BELOW_ZERO and size <= 0
        ):
            return None
    return found


def _anew(rest: Residual, faults: Sequence[Linear]) -> Beside | None:
    """Fits model and faults together by least squares; None if the fit fails."""
    from scipy.optimize import least_squares  # slow to import

    coordinates, curves, scale = rest.coordinates, rest.curves, rest.scale
    measured = np.concatenate([curve.torque for curve in curves])
    count = coordinates.point.size
    far = 10 * np.abs(measured).max()

    def parts(at: Array) -> tuple[Array, Array]:
        model, start = coordinates.at(at[:count])
        pairs = zip(faults, at[count:].tolist(), strict=True)
        with np.errstate(over="ignore", invalid="ignore"):  # at a pole
            plain = np.concatenate([predicted(model, start, curve) for curve in curves])
            added = [one.hypothesis.torque(model, start, size) - plain for one, size in pairs]
            return plain, np.column_stack(added) / scale[:, None]

    def residual(at: Array) -> Array:
        try:
            plain, added = parts(at)
        except (InputError, OverflowError):
            return np.full(measured.size, far)
        with np.errstate(over="ignore", invalid="ignore"):
            left = (measured - plain) / scale - added.sum(axis=1)
        return np.clip(np.where(np.isfinite(left), left, far), -far, far)  # a pole is near

    begin = np.concatenate([coordinates.point, [one.size for one in faults]])
    found = least_squares(residual, begin, x_scale="jac", max_nfev=STEPS)
    if not np.isfinite(found.fun).all() or not np.isfinite(found.jac).all():
        return None
    try:
        _, added = parts(found.x)
    except (InputError, OverflowError):
        return None  # the fit ended at parameters without a model
    finite = np.isfinite(added).all()  # else the fit ended at a pole
    return Beside(found.fun, -found.jac, found.x[count:], added) if finite else None
