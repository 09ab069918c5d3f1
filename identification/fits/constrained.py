"""Fits of any kind of model with parameters that the user fixed or bounded."""

import math
from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.around import Asymmetric, Clipped
from ...hysteresis.bouc_wen.model import BoucWen
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves, noise_floor
from .objective import Fitted, InitialTorque, scored, torque_errors
from .parameters import Constraints, Parameter, parameters_of, with_values
from .search import AGREEING, MARGIN, REJECTED, Evaluation, Search, sobol_points

SCREENED = 32
STALLED = 1e-8  # relative change that ends a run; physical parameters depend on each other
RUNS = 200  # evaluations per coordinate
FOLDS = 12.0  # range of the logarithm of a parameter to either side of the free fit
FARTHEST = 1e3  # range of other parameters, over their size
SPREAD = 1.5  # range of the starts to either side, in folds or sizes


def constrained_fit(
    found: Fitted,
    curves: Sequence[Curve],
    constraints: Constraints,
    rng: int | np.random.Generator | None,
) -> Fitted:
    """Returns the best certified model of a kind whose parameters obey constraints.

    `found` is the fit without constraints; its grids and degrees stay. All free parameters, and the
    torque at the beginning, are searched by bounded least squares from that fit and from points
    around it: parameters above a least value by their logarithm, others over their size.
    """
    problem = _Constrained(found, Curves(curves).fitted(), constraints)
    free = int(np.count_nonzero(problem.low < problem.high))
    search = Search(problem, SCREENED + 1 + RUNS * (free + 1), stalled=STALLED)
    around = sobol_points(problem.near[0], problem.near[1], SCREENED, rng)
    starts = search.screened(np.vstack([problem.start, around]))
    search.run(starts, problem.floor, AGREEING)
    if search.best is None:
        raise InputError(
            f"no certified model {found.model.name!r} with {', '.join(constraints.names)} as given "
            "fits these curves: fix or bound fewer parameters, or give wider bounds"
        )
    model, start = problem.at(search.best)
    return scored(problem.safe(model), start, problem.curves)


class _Constrained:
    """The errors of models of one kind over the box that constraints allow.

    A point has a number for each parameter, and the torque at the beginning over the peak.
    """

    def __init__(self, found: Fitted, curves: Curves, constraints: Constraints) -> None:
        self.curves, self.peak = curves, curves.peak
        self.floor = noise_floor(curves) / self.peak
        self.content = found.model.to_dict()
        self.parameters = parameters_of(found.model, constraints)
        user = constraints.ends_of([one.name for one in self.parameters])
        self.scale = np.array([self._size(one) for one in self.parameters] + [self.peak])
        self.is_log = np.array([_is_log(one) for one in self.parameters] + [False])
        least = [one.least if math.isfinite(one.least) else 0.0 for one in self.parameters]
        self.least = np.array([*least, 0.0])
        values = np.array([one.value for one in self.parameters])
        start = found.initial_torque if not isinstance(found.initial_torque, str) else 0.0
        self.start = self._coordinates(np.append(values, start))
        reach = np.where(self.is_log, FOLDS, FARTHEST)
        low = self._coordinates(np.append(user[0], -np.inf))
        high = self._coordinates(np.append(user[1], np.inf))
        self.low = np.where(np.isfinite(low), low, np.minimum(self.start, high) - reach)
        self.high = np.where(np.isfinite(high), high, np.maximum(self.start, self.low) + reach)
        self.start = np.clip(self.start, self.low, self.high)
        self.near = [
            np.clip(self.start + side * SPREAD, self.low, self.high) for side in (-1.0, 1.0)
        ]

    def at(self, point: Array) -> tuple[HysteresisModel, InitialTorque]:
        """Returns model and torque at the beginning of a point."""
        with np.errstate(over="ignore"):
            folds = self.least + np.exp(np.where(self.is_log, point, 0.0))
            values = np.where(self.is_log, folds, point * self.scale).tolist()
        numbers = {
            one.path: min(max(value, one.low), one.high)
            for one, value in zip(self.parameters, values[:-1], strict=True)
        }
        return with_values(self.content, numbers), values[-1]

    def evaluate(self, point: Array) -> Evaluation:
        """Returns the relative errors of a point and its missing margin."""
        rejected = np.full(sum(one.torque.size for one in self.curves), REJECTED)
        try:
            model, start = self.at(point)
            errors = torque_errors(model, start, self.curves) / self.peak
            lacking = self.lacking(model, start)
        except InputError:  # no such model, or no such beginning
            return Evaluation(rejected, 1.0, point.copy())
        errors = np.where(np.isfinite(errors), errors, REJECTED)
        return Evaluation(errors, lacking, point.copy())

    def lacking(self, model: HysteresisModel, start: InitialTorque) -> float:
        """Returns the missing margin of a model, at all angles or in the range: the smaller one."""
        if isinstance(model, BoucWen):  # dissipative up to |gamma| = beta
            return max(abs(model.gamma) / model.beta - 1 + MARGIN / 2, 0.0)
        model = self.safe(model)
        certificate = model.certificate()
        begun = model.start(float(self.curves[0].angle[0]), float(start))
        if not (certificate.dissipative and model.start_is_certified(begun)):
            return max(MARGIN, MARGIN - certificate.margin)
        return min(max(MARGIN - certificate.margin, 0.0), 1.0)

    def safe(self, model: HysteresisModel) -> HysteresisModel:
        """Returns the model, with constant torque outside the curves if certified only so."""
        if not isinstance(model, Asymmetric) or isinstance(model.model, Clipped):
            return model
        if model.certificate().margin >= MARGIN / 2:
            return model
        inner = Clipped(model=model.model, angle_range=self.curves.angle_range)
        return Asymmetric(model=inner, polynomial=model.polynomial)

    def _size(self, one: Parameter) -> float:
        """Returns the size of a parameter: the largest in its list, or of its value and bounds."""
        alike = [two.value for two in self.parameters if two.path[:-1] == one.path[:-1]]
        alike = alike if isinstance(one.path[-1], int) else [one.value]
        ends = [end for end in (one.low, one.high) if math.isfinite(end)]
        return max(map(abs, [*alike, *ends])) or 1.0

    def _coordinates(self, values: Array) -> Array:
        with np.errstate(divide="ignore", invalid="ignore"):
            logs = np.log(np.maximum(values - self.least, 0.0))
        return np.where(self.is_log, logs, values / self.scale)


def _is_log(one: Parameter) -> bool:
    """Returns whether a parameter is searched by its logarithm: a single number above its least."""
    inside = one.value > one.least > -math.inf and isinstance(one.path[-1], str)
    return inside and (one.low > one.least or one.low == -math.inf)
