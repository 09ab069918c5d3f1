"""The certified fits by the name of their model, and fits of rate and play with a model.

A fit is a function `fit(curves, **options)` of the measured curves. It takes a random generator as
the option `rng` if it depends on random numbers, and returns a model that is certified and
dissipative, at least with constant torque outside the angles of the curves; or a `Fitted` with this
model.
"""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np
from scipy.optimize import minimize_scalar, nnls

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.around import Asymmetric, Backlash, Viscoelastic, without_rate
from ...hysteresis.bouc_wen.model import BoucWen
from ...hysteresis.dahl.model import Dahl, Duhem
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ...hysteresis.preisach.model import Preisach
from ...hysteresis.protocol import HysteresisModel
from ...hysteresis.stops import HingedStops, PrandtlIshlinskii
from ..data.curves import Curve, noise_floor
from .beside_polynomial import fit_asymmetric, fit_bouc_wen, fit_dahl, fit_duhem
from .certified import certified_fit, common_torque
from .constrained import constrained_fit
from .objective import Fitted, InitialTorque, price, scored, times_of, torque_errors
from .parameters import FREE, Constraints, bounded_least_squares
from .search import least_of
from .tangent import beside, coordinates_of, independent, tangent
from .weights import fit_hinged_stops, fit_prandtl_ishlinskii, fit_preisach

Rate = Literal["none", "viscous", "relaxing"]
ROUNDS = 12  # largest number of rounds; 3 to 6 are usual
CONVERGED = 1e-4  # change of the elements' torque between rounds at convergence, over the peak
TIMES = 24  # relaxation times on the grid
RELAXATION = ("relaxation_stiffness", "relaxation_time")
Play = Literal["none", "fit"]
LARGEST = 0.1  # widest gap of the search, as a share of the range of angles
GAPS = 6  # number of gaps on the grid, of which the first is zero
CLOSE = 1e-3  # tolerance of the best gap, relative to the widest
CERTAIN = 4.0  # deviations of the noise, above which a torque shows the face in contact
QUICK = 600  # evaluations of a fit that only compares gaps or rounds
FitFunction = Callable[..., Any]
FITS: dict[str, FitFunction] = {
    JilesAtherton.name: certified_fit,
    Asymmetric.name: fit_asymmetric,
    BoucWen.name: fit_bouc_wen,
    PrandtlIshlinskii.name: fit_prandtl_ishlinskii,
    Preisach.name: fit_preisach,
    HingedStops.name: fit_hinged_stops,
    Dahl.name: fit_dahl,
    Duhem.name: fit_duhem,
}


def rate_of(model: HysteresisModel) -> Rate:
    """Returns the rate-dependent part of a fitted model."""
    if not isinstance(model, Viscoelastic):
        return "none"
    return "relaxing" if model.relaxation_stiffness > 0 else "viscous"


def fit_beside_rate(
    curves: Sequence[Curve],
    rate: Rate,
    fit: Callable[[Sequence[Curve]], Fitted],
    quick: Callable[[Sequence[Curve]], Fitted],
    constraints: Constraints = FREE,
) -> Fitted:
    """Fits a hysteresis model and the rate-dependent elements beside it, in turn, to timed curves.

    Each round fits the hysteresis model to the torque less that of the elements (by `quick`, with
    less effort, in all rounds but the last), and then solves for the elements beside the
    derivatives of the torque with respect to the model's parameters, so that torque that the model
    can describe too does not count (variable projection, Golub and Pereyra 1973). The relaxation
    time is refined from the best one of a grid. Dampings and stiffnesses are at least 0; a Maxwell
    element that lowers the error by less than the cost of its parameters (the Bayesian information
    criterion) is left out.
    """
    peak = max(float(np.abs(curve.torque).max()) for curve in curves)
    times = _times(curves) if rate == "relaxing" else np.empty(0)
    if constraints.has(*RELAXATION[1:]) and times.size:
        ends = constraints.box(RELAXATION[1], (times[0], times[-1]), 0.0)
        times = np.unique(np.geomspace(*ends, TIMES))
    rest, slow = list(curves), quick(curves)
    found, before = Viscoelastic(model=slow.model), np.zeros(sum(one.angle.size for one in curves))
    for _ in range(ROUNDS):
        found = _with_elements(slow.model, slow.initial_torque, curves, times, constraints)
        now = _torque(found, curves)
        if np.abs(now - before).max() <= CONVERGED * peak:
            break
        before = now
        parts = np.split(now, np.cumsum([one.angle.size for one in curves])[:-1])
        pairs = zip(curves, parts, strict=True)
        rest = [replace(curve, torque=curve.torque - torque) for curve, torque in pairs]
        slow = quick(rest)
    slow = fit(rest)
    return scored(replace(found, model=slow.model), slow.initial_torque, curves)


def _times(curves: Sequence[Curve]) -> Array:
    """Returns the relaxation times that curves can show [s]: from two samples to half a curve."""
    steps = [np.median(np.diff(times_of(curve))) for curve in curves]
    longest = max(float(np.ptp(times_of(curve))) for curve in curves)
    return np.geomspace(2 * min(steps), longest / 2, TIMES)


def _with_elements(
    model: HysteresisModel,
    start: InitialTorque,
    curves: Sequence[Curve],
    times: Array,
    constraints: Constraints,
) -> Viscoelastic:
    """Returns the model beside the elements that best explain its residual."""
    rest = -torque_errors(model, start, curves)
    if not np.isfinite(rest).all():
        return Viscoelastic(model=model, damping=max(constraints.ends("damping")[0], 0.0))
    free = coordinates_of(model, start, fitted_start=True, constraints=constraints)
    basis = independent(tangent(free, curves))
    velocity = _torque(Viscoelastic(model=model, damping=1.0), curves)[:, None]
    rest = beside(basis, rest)
    names = ("damping", RELAXATION[0])

    def least(columns: Array) -> tuple[Array, float]:
        columns = beside(basis, columns)
        if not constraints.has(*names):
            return nnls(columns, rest)
        low, high = np.array([constraints.ends(name) for name in names[: columns.shape[1]]]).T
        return bounded_least_squares(columns, rest, np.maximum(low, 0), high)

    (damping,), alone = least(velocity)
    found = Viscoelastic(model=model, damping=float(damping))
    if times.size == 0:
        return found

    def solved(time: float) -> tuple[Array, float]:
        element = Viscoelastic(model=model, relaxation_stiffness=1.0, relaxation_time=time)
        return least(np.column_stack([velocity, _torque(element, curves)]))

    time = least_of(times, lambda time: solved(time)[1]) if times.size > 1 else float(times[0])
    (damping, stiffness), loss = solved(time)
    is_needed = constraints.has(*RELAXATION)
    if not is_needed and (alone <= loss * price(2, rest.size) or stiffness == 0):
        return found
    maxwell = {"relaxation_stiffness": float(stiffness), "relaxation_time": time}
    return Viscoelastic(model=model, damping=float(damping), **maxwell)


def _torque(model: Viscoelastic, curves: Sequence[Curve]) -> Array:
    return np.concatenate([model.rate_torque(one.angle, times_of(one)) for one in curves])


def play_of(model: HysteresisModel) -> Play:
    """Returns whether a fitted model is behind play."""
    return "fit" if isinstance(without_rate(model), Backlash) else "none"


def without_play(model: HysteresisModel) -> HysteresisModel:
    """Returns the model behind the play, or the model itself without play."""
    return model.model if isinstance(model, Backlash) else model


def fit_behind_play(
    curves: Sequence[Curve],
    fit: Callable[[Sequence[Curve]], Fitted],
    quick: Callable[[Sequence[Curve]], Fitted],
    constraints: Constraints = FREE,
) -> Fitted:
    """Fits a hysteresis model and the gap before it.

    For a given gap, the sign of the torque shows the face in contact, and so the angle of the
    suit's side, to which the model is fitted; where the torque is lost in the noise, the suit's
    side moves only as far as the joint pushes it. The gap, up to 10 % of the range, is the gap with
    the least error of the model behind it: the best of a grid, refined by Brent's bounded
    search. A gap that lowers the error by less than the cost of its parameter (the
    Bayesian information criterion) does not count, and the model is returned without it. `quick` is
    the fit with less effort, which compares gaps.
    """
    fixed, most = constraints.ends("gap")
    if fixed == most:
        return _behind(curves, fixed, fit)
    found: dict[float, Fitted] = {}

    def loss(gap: float) -> float:
        if gap not in found:
            found[gap] = _behind(curves, gap, quick)
        return found[gap].loss

    widest = LARGEST * max(float(np.ptp(curve.angle)) for curve in curves)
    first, widest = constraints.box("gap", (0.0, widest))
    grid = np.linspace(first, widest, GAPS)
    best = int(np.argmin([loss(float(gap)) for gap in grid]))
    near = grid[max(best - 1, 0)], grid[min(best + 1, GAPS - 1)]
    fine: Any = {"xatol": CLOSE * widest}
    minimize_scalar(lambda gap: loss(float(gap)), bounds=near, method="bounded", options=fine)
    gap = min(found, key=loss)
    chosen = _behind(curves, gap, fit)
    if first > 0:
        return chosen
    without = _behind(curves, 0.0, fit)
    worth = price(1, sum(curve.angle.size for curve in curves))
    return without if without.loss <= chosen.loss * worth else chosen


def _behind(
    curves: Sequence[Curve], gap: float, fit: Callable[[Sequence[Curve]], Fitted]
) -> Fitted:
    """Returns the fit of a model behind a known gap, with its error along the curves."""
    if gap == 0:
        slow = fit(curves)
        return scored(slow.model, slow.initial_torque, curves)
    slow = fit([replace(one, angle=suit_angles(one, gap)) for one in curves])
    behind = Backlash(model=slow.model, gap=gap)
    starts: list[InitialTorque] = [slow.initial_torque]
    # A torque within the noise may mean a start inside the gap: the better start is taken.
    if not isinstance(slow.initial_torque, str) and slow.initial_torque != 0:
        starts.append(0.0)
    return min((scored(behind, one, curves) for one in starts), key=lambda one: one.loss)


def suit_angles(curve: Curve, gap: float) -> Array:
    """Returns the angles of the suit's side of a gap [rad], shape (n,)."""
    side = np.where(
        np.abs(curve.torque) > CERTAIN * noise_floor([curve]), np.sign(curve.torque), 0.0
    )
    end, found = float(curve.angle[0]), np.empty_like(curve.angle)
    for i, (angle, face) in enumerate(zip(curve.angle.tolist(), side.tolist(), strict=True)):
        low, high = angle - gap / 2, angle + gap / 2
        end = angle - face * gap / 2 if face else min(max(end, low), high)
        found[i] = end
    return found


def register_fit(model_name: str, fit: FitFunction) -> None:
    """Makes a fit known to `identify`, for a hysteresis model from outside the package.

    From then on `identify(curves, model=model_name)` uses it, and `select` tries it.

    Args:
        model_name: The `name` of the model.
        fit: A function as this module describes it.
    """
    if not callable(fit):
        raise InputError(f"fit of {model_name!r} is {fit!r}: give a function of the curves")
    if FITS.setdefault(model_name, fit) is not fit:
        raise InputError(f"model {model_name!r} has a fit already: choose another name")


def fit_model(
    name: str,
    curves: Sequence[Curve],
    rng: np.random.Generator,
    *,
    rate: Rate = "none",
    play: Play = "none",
    constraints: Constraints = FREE,
    **options: Any,
) -> Fitted:
    """Fits the model `name` of `FITS` to curves, with rate and play if asked for.

    The torque at the beginning is identified here for fits that return a bare model. `rng` is for
    seeded fits, and `options` are those of the fit.
    """
    takes = inspect.signature(FITS[name]).parameters
    less = {"budget": min(QUICK, options.get("budget", QUICK))} if "budget" in takes else {}
    if rate != "none":
        fit = partial(fit_model, name, rng=rng, play=play, constraints=constraints, **options)
        return fit_beside_rate(curves, rate, fit, partial(fit, **less), constraints)
    if play != "none":
        fit = partial(fit_model, name, rng=rng, constraints=constraints, **options)
        return fit_behind_play(curves, fit, partial(fit, **less), constraints)
    if "rng" in takes:
        options["rng"] = rng
    if "constraints" in takes:
        options["constraints"] = constraints
    found = FITS[name](curves, **options)
    if isinstance(found, HysteresisModel):
        found = scored(found, common_torque(found, curves), curves)
        if constraints and not constraints.hold(found.model):
            return constrained_fit(found, curves, constraints, rng)
        return found
    return replace(found, history=())  # pairs of a certified fit, which no user of trials expects
