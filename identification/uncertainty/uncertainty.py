"""How sure the parameters of an identified Jiles-Atherton model are."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ...hysteresis.around.held import Held
from ...hysteresis.jiles_atherton.kernels import is_exact
from ...hysteresis.jiles_atherton.model import PARAMETERS, UNIT_PER_RADIAN, JilesAtherton
from ...hysteresis.protocol import HysteresisModel
from ..curves import Curve, Curves
from ..fits.certified import refined
from ..objective import CurveObjective, InitialTorque
from ..thinning import thinned
from .likelihood import Likelihood
from .sloppy_directions import beside_best, sloppy_directions

LOWEST = (0.0, 0.0, -np.inf, 1.0, 0.0, -np.inf)
CONFIDENCE = 0.95
FARTHEST = np.log(1e4)  # beyond it an interval has no end


@dataclass(frozen=True, kw_only=True)
class Uncertainty:
    """What curves say about the parameters of a model, in the model's own units.

    The errors of the torque are taken as independent and normal, with one deviation that the
    residuals tell. `covariance` and `condition` are those of the model linearized at its
    parameters; `intervals` and `samples` are not linearized. Only the samples are restricted to
    certified models.

    Attributes:
        names: The names Ms, a, alpha, c, k, and initial_torque if it was identified.
        values: The parameters, shape (n,).
        covariance: The covariance of the parameters, shape (n, n).
        condition: The condition number of the Jacobian by log Ms, log a, alpha Ms/a, log (c-1),
            log k (and the initial torque over the peak); it tells how many times better the best
            known combination of parameters is known than the worst.
        sloppy: What the curves leave open, as sentences; empty if they tell every parameter.
        intervals: The 95 % intervals by profile likelihood, lower and upper end, shape (n, 2).
            Where the curves set no limit the end is that of all models: 0, 1 for c, or infinite.
        samples: Models that noisy repetitions of the curves would have led to, each certified.
        noise: Standard deviation of the torque [N·m], for a curve of mean weight.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    condition: float
    sloppy: tuple[str, ...]
    intervals: Array
    samples: tuple[HysteresisModel, ...]
    noise: float

    @property
    def standard_errors(self) -> Array:
        """Standard deviation of each parameter, shape (n,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the parameters, shape (n, n)."""
        return self.covariance / np.outer(self.standard_errors, self.standard_errors)


def uncertainty(
    model: HysteresisModel,
    curves: Sequence[Curve],
    *,
    initial_torque: InitialTorque = 0.0,
    samples: int = 0,
    seed: int = 0,
) -> Uncertainty:
    """Estimates how certain the parameters of a fitted Jiles-Atherton model are.

    Args:
        model: Identified Jiles-Atherton model with c > 1, bare or held.
        curves: Curves that it was fitted to; those with role "fit" are used. Of more than 50,000
            samples only those count that `thinned` leaves, which widens the intervals.
        initial_torque: Torque with which every curve begins, as `certified_fit` takes it.
        samples: Number of models to draw (parametric bootstrap): the model's own curves with
            random noise are fitted as by `certified_fit`, starting from the model.
        seed: Seed of the noise.

    Raises:
        InputError: The model is of another kind, or the curves are unusable.
    """
    at_least("samples", samples, 0)
    at_least("seed", seed, 0)
    bare = _jiles_atherton(model)
    measured = thinned(Curves(curves).fitted())
    if isinstance(model, Held):
        measured = Curves(
            replace(one, angle=np.clip(one.angle, *model.angle_range)) for one in measured
        )
    objective = CurveObjective(measured, initial_torque=initial_torque)
    degrees = bare.in_unit("deg")
    row = np.array([getattr(degrees, name) for name in PARAMETERS])
    names = PARAMETERS
    if initial_torque == "identified":
        names = (*PARAMETERS, "initial_torque")
        row = np.append(row, np.mean([curve.torque[0] for curve in measured]))
    if objective.torque.size <= row.size:
        raise InputError(
            f"the fitted curves have {objective.torque.size} samples in all: give more than the "
            f"{row.size} parameters"
        )
    if not np.isfinite(objective.responses(row)).all():
        raise InputError(
            "the model meets its pole on the curves it is asked about: give those it was fitted to"
        )
    likelihood = Likelihood(objective, row)
    if initial_torque == "identified":
        likelihood.center[5] = likelihood.best[5]  # the model does not tell it
    row = likelihood.row(likelihood.center)
    unit = UNIT_PER_RADIAN[bare.angle_unit] / UNIT_PER_RADIAN["deg"]
    units = np.array([1.0, unit, unit, 1.0, unit, 1.0])[: row.size]
    unit_names = ("", "", f"{bare.angle_unit}/(N·m)", "", "", "N·m")
    slopes = units * likelihood.by_point(likelihood.center)
    intervals = _intervals(likelihood) * units[:, None]
    return Uncertainty(
        names=names,
        values=row * units,
        covariance=likelihood.covariance(likelihood.center) * np.outer(slopes, slopes),
        condition=float(np.linalg.cond(likelihood.jacobian(likelihood.center))),
        sloppy=(
            *beside_best(likelihood),
            *sloppy_directions(likelihood, units, unit_names),
            *_open_ends(names, intervals),
        ),
        intervals=intervals,
        samples=tuple(
            refined(repetition, row, initial_torque=initial_torque).model
            for repetition in _repetitions(likelihood, row, samples, seed)
        ),
        noise=float(np.sqrt(likelihood.variance)),
    )


def _intervals(likelihood: Likelihood) -> Array:
    """Returns both ends of each parameter by profile likelihood, shape (n, 2).

    An interval ends where the least cost at a fixed value of the parameter exceeds the least of all
    by t^2 variances (Bates and Watts, Nonlinear Regression Analysis, 1988, section 6.1).
    """
    t_limit = float(t.ppf((1 + CONFIDENCE) / 2, likelihood.freedom))
    growth = t_limit**2 * likelihood.variance
    size = likelihood.best.size
    intervals = np.column_stack([LOWEST[:size], np.full(size, np.inf)])
    for i, axis in enumerate(np.eye(size)):
        for side, sign in enumerate((-1, 1)):
            farthest = FARTHEST + sign * (likelihood.center - likelihood.best)[i]
            if farthest > 0:
                end, limited = likelihood.walk(sign * axis, growth, farthest)
                intervals[i, side] = likelihood.row(end)[i] if limited else intervals[i, side]
    return intervals


def _open_ends(names: Sequence[str], intervals: Array) -> Iterator[str]:
    for name, low, high, lowest in zip(names, *intervals.T, LOWEST, strict=False):
        if low == lowest:
            yield f"the curves set no lower limit to {name}"
        if high == np.inf:
            yield f"the curves set no upper limit to {name}"


def _jiles_atherton(model: HysteresisModel) -> JilesAtherton:
    inner = model.model if isinstance(model, Held) else model
    if not isinstance(inner, JilesAtherton) or not is_exact(inner.parameter_vector) or inner.c <= 1:
        raise InputError(
            f"model is {model!r}: the uncertainty is known for Jiles-Atherton models only, bare or "
            "held, of form 'bulk' without a clamp and with c above 1"
        )
    return inner


def _repetitions(
    likelihood: Likelihood, row: Array, samples: int, seed: int
) -> Iterator[list[Curve]]:
    """Yields the curves of the model with noise of their own."""
    objective = likelihood.objective
    torque = objective.responses(row)[0]
    deviation = np.sqrt(likelihood.variance / objective.weight)
    ends = np.cumsum([curve.torque.size for curve in objective.curves])[:-1]
    for child in np.random.SeedSequence(seed).spawn(samples):
        noise = deviation * np.random.default_rng(child).standard_normal(torque.size)
        parts = np.split(torque + noise, ends)
        yield [
            replace(curve, torque=part) for curve, part in zip(objective.curves, parts, strict=True)
        ]
