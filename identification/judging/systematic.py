"""Errors of the measurement that noise does not show: an offset of the sensor, and a dashpot."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.linalg import matmul_toeplitz

from ...arrays import Array
from ...hysteresis.around import Viscoelastic
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves
from .noise import GRID, Noise
from .sentences import sentence

DEPENDENT = 1e-8  # relative size of a combination of coordinates that curves do not determine
UNLIKELY = 1e-3  # weight of a noise that is left out
LARGE = 0.05  # deviation of a torque over the peak, from which on the curves leave it open
WIDTH = 1.96  # half width of an interval of 95 %, in deviations
SAME = 1e-3  # part of a column that other columns do not explain, below which they are alike


def estimator_covariance(slopes: Array, noise: Noise, sizes: Sequence[int], scale: Array) -> Array:
    """Returns the covariance (p, p) of least squares, which assume white noise, under any noise.

    With the pseudo-inverse P of the slopes (samples, p) and the covariance V of the noise it is
    P V P' (White 1980, Econometrica 48, 817, for errors that are not alike), here averaged over the
    noises. `scale` is the relative deviation of the noise of each sample, shape (samples,).
    """
    inverse = np.linalg.pinv(slopes, rcond=DEPENDENT).T * scale[:, None]
    parts = np.split(inverse, np.cumsum(sizes)[:-1])
    found, total = np.zeros((slopes.shape[1],) * 2), 0.0
    for weight, variance, (memory, white) in zip(noise.weight, noise.variance, GRID, strict=True):
        if weight < UNLIKELY:
            continue
        total += weight
        for part in parts:
            spread = white * part if memory else part
            if memory:
                slow = memory ** np.arange(len(part))
                spread = spread + (1 - white) * matmul_toeplitz(slow, part)
            found += weight * variance * part.T @ spread
    return found / total


class Term(NamedTuple):
    """Estimate of a quantity that is not in the model, with its standard deviation."""

    value: float
    deviation: float

    def interval(self, value: float) -> tuple[float, float]:
        """Returns the 95 % interval about a value, by a normal distribution."""
        return value - WIDTH * self.deviation, value + WIDTH * self.deviation

    def drawn(self, rng: np.random.Generator) -> float:
        """Returns a random value of this distribution."""
        return self.value + self.deviation * float(rng.standard_normal())


@dataclass(frozen=True, kw_only=True)
class Systematic:
    """Systematic errors that curves allow beside a model; None if the curves do not limit an error.

    The offset is not limited beside a model whose spring has a rest angle.
    """

    offset: Term | None  # of the torque sensor [N·m]
    damping: Term | None  # viscous torque per rate [N·m·s/rad]; None if the model has it
    left_open: tuple[str, ...]  # what the curves leave open, as phrases


def systematic(
    model: HysteresisModel,
    curves: Curves,
    slopes: Array,
    residual: Array,
    weights: Array,
    noise: Noise,
    relative: Array,
) -> Systematic:
    """Estimates offset and damping from the residual (samples,) [N·m] of a fit.

    Each is the least-squares estimate of one more column beside the slopes (samples, p) of the fit,
    found from the part of the column that the slopes do not explain (Frisch and Waugh 1933,
    Econometrica 1, 387). Slopes and residual have the factors `weights`; `relative` is the relative
    deviation of the noise of each sample.
    """
    sizes = [curve.angle.size for curve in curves]
    rate = None if isinstance(model, Viscoelastic) else rates_of(curves)
    columns = [np.ones(residual.size), *([] if rate is None else [rate])]
    asked = np.column_stack(columns) * weights[:, None]
    rests = asked - slopes @ np.linalg.lstsq(slopes, asked, rcond=None)[0]

    def term(column: Array, rest: Array) -> Term:
        if np.linalg.norm(rest) < SAME * np.linalg.norm(column):
            return Term(0.0, np.inf)
        variance = estimator_covariance(rest[:, None], noise, sizes, relative)[0, 0]
        return Term(float(rest @ residual / (rest @ rest)), float(np.sqrt(variance)))

    offset, *others = map(term, asked.T, rests.T)
    most, left_open = LARGE * curves.peak, []
    if offset.deviation > most:
        left_open.append(sentence("left open offset"))
    damping = others[0] if others else None
    if not isinstance(model, Viscoelastic):
        fastest = 0.0 if rate is None else float(np.abs(rate).max())
        if damping is None or damping.deviation * fastest > most:
            kind = "left open times" if damping is None else "left open rate"
            left_open.append(sentence(kind, fastest=fastest))
            damping = None
    return Systematic(
        offset=None if offset.deviation > most else offset,
        damping=damping,
        left_open=tuple(left_open),
    )


def rates_of(curves: Sequence[Curve]) -> Array | None:
    """Returns the rate of each sample [rad/s], end to end; None if a curve has no times."""
    rates = [np.gradient(curve.angle, curve.time) for curve in curves if curve.time is not None]
    return np.concatenate(rates) if len(rates) == len(curves) else None
