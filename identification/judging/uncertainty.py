"""Uncertainty of the parameters and the torque of an identified model."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import matmul_toeplitz
from scipy.special import stdtrit

from ...arrays import Array
from ...checks import at_least, check_seed
from ...errors import InputError, shown
from ...hysteresis.around import Clipped, Viscoelastic, without_rate
from ...hysteresis.jiles_atherton.kernels import is_exact
from ...hysteresis.jiles_atherton.model import PARAMETERS, JilesAtherton
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves
from ..fits.certified import refined
from ..fits.objective import InitialTorque, sample_weights, torque_errors
from ..fits.parameters import FREE, Constraints
from ..fits.registry import FITS, fit_model, play_of, rate_of, without_play
from ..fits.search import MARGIN
from ..fits.tangent import STEP, Coordinates, coordinates_of, tangent
from .noise import GRID, Noise, estimate_noise, uneven_noise
from .sentences import sentence

CONFIDENCE = 0.95
FARTHEST = math.log(1e4)  # largest distance of the end of an interval; a farther end is open
NEAR = 1e-3  # distance from the least margin of the certificate, within which it binds
DEPENDENT = 1e-8  # relative size of a combination of coordinates that curves do not determine
UNLIKELY = 1e-3  # weight of a noise that is left out
LARGE = 0.05  # deviation of a torque over the peak, from which on the curves leave it open
WIDTH = 1.96  # half width of an interval of 95 %, in deviations
SAME = 1e-3  # part of a column that other columns do not explain, below which they are alike


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
    left_open: tuple[str, ...]  # errors that the curves leave open, as phrases


@dataclass(frozen=True, kw_only=True)
class Uncertainty:
    """Uncertainty of the parameters of a model, in the model's own units.

    Everything is linearized at the given model in the coordinates of the fit: the logarithm of a
    parameter that must be above some value, and the parameter itself otherwise. The noise of the
    torque has a white and a slow part, estimated from the residual (see `judging.noise`).

    Attributes:
        names: Names of the fitted parameters, those in lists as weights[3].
        values: The parameters, shape (n,).
        standard_errors: Standard deviation of each parameter, shape (n,).
        condition: Condition number of the derivatives with respect to relative changes of the
            parameters: how many times better the best known combination is known than the worst.
        intervals: The 95 % interval of each parameter, lower and upper end, shape (n, 2). Each is
            valid for its own parameter, not for all at once. Where the certificate binds, it is
            one-sided in the direction of the certificate's margin. Where the curves set no limit,
            an end is that of all models.
        samples: Models as fits to repetitions of the curves would give, with other noise and other
            systematic errors; each is certified.
        offset: Offset of the torque sensor [N·m] that the curves allow beside the model, with its
            standard deviation; None where they do not limit it.
        left_open: Systematic errors that the curves do not limit, so that no sample has them, as
            phrases.
        offset_open: Kinds of model that fit the curves equally well with other offsets of the
            torque sensor, such as models whose spring has a rest angle: the kind of the model if
            `offset` is None, and in `Selection.uncertainty` kinds of its samples too.
        noise: Noise of the torque, for a curve of mean weight.
    """

    names: tuple[str, ...]
    values: Array
    standard_errors: Array
    condition: float
    intervals: Array
    samples: tuple[HysteresisModel, ...]
    offset: Term | None
    left_open: tuple[str, ...]
    offset_open: tuple[str, ...]
    noise: Noise
    _coordinates: Coordinates = field(repr=False)
    _covariance: Array = field(repr=False)
    _limit: Array | None = field(repr=False)

    @property
    def open_ends(self) -> dict[str, list[str]]:
        """Names of the parameters that the curves do not limit, by the end that is missing."""
        low = self.intervals[:, 0] == self._coordinates.least
        high = self.intervals[:, 1] == np.inf
        ends = {"limit": low & high, "lower limit": low & ~high, "upper limit": high & ~low}
        return {
            end: np.array(self.names)[here].tolist() for end, here in ends.items() if here.any()
        }

    def band(self, curve: Curve) -> tuple[Array, Array]:
        """Returns the ends of the 95 % interval of the torque along a curve [N·m], (samples,) each.

        They follow from the uncertainty of the parameters, if the kind of model is right.

        Args:
            curve: Motion; its torque is used only where the fit began with the measured one.
        """
        if not isinstance(curve, Curve):
            raise InputError(f"curve is {shown(curve)}: give a Curve, whose torque may be zeros")
        model, start = self._coordinates.at(self._coordinates.point)
        torque = torque_errors(model, start, [curve]) + curve.torque
        down, up = _spread(self._covariance, self._limit, tangent(self._coordinates, [curve]))
        width = _width(self.noise)
        return torque - width * down, torque + width * up


def uncertainty(
    model: HysteresisModel,
    curves: Sequence[Curve],
    *,
    initial_torque: InitialTorque = 0.0,
    fitted_start: bool = False,
    constraints: Constraints = FREE,
    samples: int = 0,
    seed: int = 0,
) -> Uncertainty:
    """Estimates the uncertainty of a fitted model; `Fit.uncertainty` calls it.

    Args:
        model: Identified model of any kind, whose fit minimized squares.
        curves: Curves that it was fitted to; those with role "fit" are used. `data.parts.thinned`
            shortens long ones, which widens the intervals.
        initial_torque: Torque with which every curve begins [N·m]; or "measured".
        fitted_start: Whether the fit chose that torque.
        constraints: Parameters that the user fixed or bounded. A fixed one, or one at its bound,
            counts as known.
        samples: Number of models to draw (parametric bootstrap): the model's own curves with noise
            as that of the residual, an offset and a damping that the curves allow are fitted anew.
        seed: Seed of all that is drawn.
    """
    at_least("samples", samples, 0)
    check_seed(seed)
    measured = Curves(curves).fitted()
    coordinates = coordinates_of(
        model, initial_torque, fitted_start=fitted_start, constraints=constraints
    )
    sizes = [curve.torque.size for curve in measured]
    if sum(sizes) <= coordinates.values.size:
        raise InputError(
            f"the fitted curves have {sum(sizes)} samples in all: give more than the "
            f"{coordinates.values.size} parameters"
        )
    residual = -torque_errors(model, initial_torque, measured)
    if not np.isfinite(residual).all():
        raise InputError(
            "the model meets its pole on these curves: give those that it was fitted to"
        )
    scale = np.sqrt(sample_weights(measured))
    slopes = tangent(coordinates, measured) * scale[:, None]
    torque = np.concatenate([curve.torque for curve in measured]) - residual
    uneven = uneven_noise(residual, torque, sizes)
    relative = uneven.at(torque)
    noise = estimate_noise(slopes / relative[:, None], residual * scale / relative, sizes, uneven)
    covariance = estimator_covariance(slopes, noise, sizes, relative)
    allowed = systematic(model, measured, slopes, residual * scale, scale, noise, relative)
    limit = _binding(coordinates)
    intervals = _intervals(coordinates, covariance, limit, noise)
    repeated = _repetitions(model, initial_torque, measured, noise, allowed, samples, seed)
    refits = tuple(
        _refitted(model, one, initial_torque, fitted_start, constraints, damping, seed)
        for one, damping in repeated
    )
    steps = np.where(
        np.isfinite(coordinates.least), 1.0, np.maximum(np.abs(coordinates.values), STEP)
    )
    return Uncertainty(
        names=coordinates.names,
        values=coordinates.values,
        standard_errors=np.sqrt(np.diag(covariance)) * coordinates.slopes(),
        condition=float(np.linalg.cond(slopes * steps)),
        intervals=intervals,
        samples=refits,
        offset=allowed.offset,
        left_open=allowed.left_open,
        offset_open=() if allowed.offset else (kind_of(model),),
        noise=noise,
        _coordinates=coordinates,
        _covariance=covariance,
        _limit=limit,
    )


def _width(noise: Noise) -> float:
    return float(stdtrit(noise.freedom, (1 + CONFIDENCE) / 2))


def _spread(covariance: Array, limit: Array | None, slopes: Array) -> tuple[Array, Array]:
    """Returns downward and upward deviations of quantities with these slopes, shape (m,) each.

    A fit at the limit of its certificate cannot move beyond it: along the change that goes with the
    margin only the inner half of the spread is left.
    """
    variance = np.maximum(np.einsum("ij,jk,ik->i", slopes, covariance, slopes), 0)
    if limit is None:
        return np.sqrt(variance), np.sqrt(variance)
    inward = slopes @ covariance @ limit / math.sqrt(limit @ covariance @ limit)
    rest = np.maximum(variance - inward**2, 0)
    down, up = np.minimum(inward, 0), np.maximum(inward, 0)
    return np.sqrt(rest + down**2), np.sqrt(rest + up**2)


def _intervals(
    coordinates: Coordinates, covariance: Array, limit: Array | None, noise: Noise
) -> Array:
    down, up = _spread(covariance, limit, np.eye(len(covariance)))
    down, up = _width(noise) * down, _width(noise) * up
    point, limited = coordinates.point, np.isfinite(coordinates.least)
    low, high = coordinates.numbers(point - down), coordinates.numbers(point + up)
    low = np.where(limited & (down > FARTHEST), coordinates.least, low)
    high = np.where(limited & (up > FARTHEST), np.inf, high)
    return np.column_stack([low, high])


def _binding(coordinates: Coordinates) -> Array | None:
    """Returns the derivative of the certificate's margin where the fit ended at its limit."""

    def margin_at(move: Array | float) -> float:
        return coordinates.at(coordinates.point + move)[0].certificate().margin

    margin = margin_at(0.0)
    if not -np.inf < margin <= MARGIN + NEAR:
        return None
    moves = STEP * np.eye(coordinates.point.size)
    limit = (np.array([margin_at(move) for move in moves]) - margin) / STEP
    return limit if np.isfinite(limit).all() and limit.any() else None


def kind_of(model: HysteresisModel) -> str:
    """Returns the name of a model without a dashpot, a gap or a range of angles around it."""
    model = without_play(without_rate(model))
    return model.model.name if isinstance(model, Clipped) else model.name


def _repetitions(
    model: HysteresisModel,
    initial_torque: InitialTorque,
    curves: Sequence[Curve],
    noise: Noise,
    allowed: Systematic,
    samples: int,
    seed: int,
) -> Iterator[tuple[list[Curve], float]]:
    """Yields a model's own curves with other noise and another offset, and a damping.

    The torque of the damping is off the curves, since the joint has it beside the model.
    """
    sizes = [curve.torque.size for curve in curves]
    ends = np.cumsum(sizes)[:-1]
    torque = torque_errors(model, initial_torque, curves)
    torque = torque + np.concatenate([curve.torque for curve in curves])
    scale, rates = np.sqrt(sample_weights(curves)), rates_of(curves)
    for child in np.random.SeedSequence(seed).spawn(samples):
        rng = np.random.default_rng(child)
        repeated = torque + noise.draw(torque, sizes, rng) / scale
        if allowed.offset is not None:
            repeated -= allowed.offset.drawn(rng)
        damping = 0.0
        if allowed.damping is not None and rates is not None:
            damping = max(allowed.damping.drawn(rng), 0.0)
            repeated -= damping * rates
        parts = np.split(repeated, ends)
        pairs = zip(curves, parts, strict=True)
        yield [replace(curve, torque=part) for curve, part in pairs], damping


def _refitted(
    model: HysteresisModel,
    curves: Sequence[Curve],
    initial_torque: InitialTorque,
    fitted_start: bool,
    constraints: Constraints,
    damping: float,
    seed: int,
) -> HysteresisModel:
    """Returns the model that a fit of the same kind finds on other curves, beside a damping."""
    if isinstance(model, JilesAtherton) and model.clamp != "none":
        raise InputError("the model is one of magnetics, whose fit is not repeated: samples=0")
    inner, name = model.model if isinstance(model, Clipped) else model, kind_of(model)
    if isinstance(inner, JilesAtherton) and inner.c > 1 and is_exact(inner.parameter_vector):
        degrees, start = inner.in_unit("deg"), initial_torque
        row = np.array([getattr(degrees, parameter) for parameter in PARAMETERS])
        if fitted_start:
            row, start = np.append(row, float(initial_torque)), "identified"
        found: HysteresisModel = refined(
            curves, row, initial_torque=start, constraints=constraints
        ).model
    elif name not in FITS:
        raise InputError(f"model is {name!r}, which has no fit that could be repeated: samples=0")
    else:
        rng, rate, play = np.random.default_rng(seed), rate_of(model), play_of(model)
        options: dict[str, Any] = {"rate": rate, "play": play, "constraints": constraints}
        found = fit_model(name, curves, rng, **options).model
    return Viscoelastic(model=found, damping=damping) if damping > 0 else found


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
