"""Jiles-Atherton of magnetics: magnetization over a field, in the form that fits it best.

A magnetization lags behind its field, so its loops run the other way round than loops of a joint.
Such models feed energy into a joint, and are never certified.
"""

from collections.abc import Sequence

import numpy as np

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ...hysteresis.jiles_atherton.model import PARAMETERS, Form, JilesAtherton
from ..data.curves import SURELY, Curve, Curves, loop_work
from .objective import CurveObjective, InitialTorque, torque_errors
from .parameters import FREE, Constraints
from .registry import Fitted
from .search import REJECTED, Evaluation, Search, sobol_points

FORMS: tuple[Form, ...] = ("bulk", "original", "derivative")
"""Forms to fit. `jiles-1992` with c / (1 + c) and k (1 + c) has the loops of `original`."""

# Search box. Fields are relative to the largest one, and Ms to the largest magnetization; the
# steepness is alpha Ms / (3 a), above 1 where the anhysteretic curve itself would turn over.
SATURATION, SHAPE, STEEPNESS = (0.5, 20.0), (0.003, 3.0), (-1.0, 3.0)
REVERSIBLE, PINNING = (0.0, 0.999), (0.001, 3.0)
SCREENED, STARTED = 64, 8
AGREEING = 3  # runs that end at the same optimum, which ends the search
BUDGET = 1_500


def magnetic_fit(
    curves: Sequence[Curve],
    form: Form,
    rng: int | np.random.Generator | None = None,
    *,
    budget: int = BUDGET,
    initial_torque: InitialTorque = 0.0,
    constraints: Constraints = FREE,
) -> Fitted:
    """Fits one form of Jiles-Atherton, with the clamp of magnetics and 0 <= c < 1.

    The curves have the magnetization as torque, over the field as angle, which is in radians.
    Bounded least squares starts from the best of some Sobol points in turn, until three runs agree:
    a form can be compared with others at its least error only, even below the noise. The result is
    no certified model.
    """
    at_least("budget", budget, SCREENED + 1)
    _refuse_joints(curves)
    problem = _Form(curves, form, initial_torque, constraints)
    search = Search(problem, budget)
    drawn = sobol_points(problem.low, problem.high, SCREENED, rng)
    search.run(search.screened(drawn)[:STARTED], agreeing=AGREEING)
    assert search.best is not None  # every point of the box is allowed
    model, start = problem.at(search.best)
    return Fitted(model, start, search.score, search.evaluations, search.agreed, search.starts)


def _refuse_joints(curves: Sequence[Curve]) -> None:
    found = loop_work(curves)
    if found.z > -SURELY:
        raise InputError(
            f"the loops take work ({found.z:.1f} standard deviations), as those of a joint do, and "
            "a magnetization lags behind its field: use the method 'certified', or give the field "
            "as the angle and the magnetization as the torque"
        )


class _Form:
    """Errors of one form over the search box.

    A point is log Ms and log a over the largest magnetization and field, the steepness (or a fixed
    or bounded alpha in its place), c, log k over that field, and, if identified, the initial
    magnetization over the largest one.
    """

    def __init__(
        self,
        curves: Sequence[Curve],
        form: Form,
        initial_torque: InitialTorque,
        constraints: Constraints,
    ) -> None:
        self.curves = curves
        self.form: Form = form
        self.initial_torque: InitialTorque = initial_torque
        self.peak = CurveObjective(curves, initial_torque=initial_torque).peak
        self.reach = float(np.abs(Curves(curves).angle_range).max())
        self.constraints = constraints
        box = [np.log(SATURATION), np.log(SHAPE), STEEPNESS, REVERSIBLE, np.log(PINNING)]
        sizes = ((0, "Ms", SATURATION, self.peak), (1, "a", SHAPE, self.reach))
        for place, name, usual, size in (*sizes, (4, "k", PINNING, self.reach)):
            if constraints.has(name):
                ends = constraints.box(name, (usual[0] * size, usual[1] * size), 0.0)
                box[place] = tuple(np.log(np.divide(ends, size)).tolist())
        if constraints.has("alpha"):
            farthest = 3 * SHAPE[1] * self.reach * STEEPNESS[1] / (SATURATION[0] * self.peak)
            box[2] = constraints.box("alpha", (-farthest, farthest))
        box[3] = constraints.box("c", REVERSIBLE)
        if initial_torque == "identified":
            box.append((-1.0, 1.0))
        self.low, self.high = np.array(box, dtype=np.float64).T

    def at(self, point: Array) -> tuple[JilesAtherton, InitialTorque]:
        """Returns model and initial magnetization of a point."""
        Ms, a, k = np.exp(point[[0, 1, 4]]) * (self.peak, self.reach, self.reach)
        alpha = point[2] if self.constraints.has("alpha") else 3 * a * point[2] / Ms
        row = dict(zip(PARAMETERS, (Ms, a, alpha, point[3], k), strict=True))
        ends = {name: self.constraints.ends(name) for name in row}
        model = JilesAtherton(
            **{name: np.clip(value, *ends[name]) for name, value in row.items()},
            form=self.form,
            clamp="jiles",
            allow_active=True,
        )
        found = self.initial_torque == "identified"
        return model, self.peak * float(point[5]) if found else self.initial_torque

    def evaluate(self, point: Array) -> Evaluation:
        """Returns the relative errors of a point, without a missing margin: none is needed."""
        errors = torque_errors(*self.at(point), self.curves) / self.peak
        return Evaluation(np.where(np.isfinite(errors), errors, REJECTED), 0.0, point.copy())
