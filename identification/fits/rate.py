"""Fits of a hysteresis model beside a dashpot, or a dashpot and a Maxwell element."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, Protocol

import numpy as np
from scipy.optimize import minimize_scalar, nnls

from ...arrays import Array
from ...hysteresis.around import Viscoelastic
from ...hysteresis.protocol import HysteresisModel
from ..curves import Curve
from ..objective import InitialTorque
from ..prediction import price, times_of, torque_errors
from ..residual.noise import independent
from ..residual.tangent import coordinates_of, tangent

Rate = Literal["none", "viscous", "relaxing"]
ROUNDS = 12  # largest number of rounds; 3 to 6 are usual
CONVERGED = 1e-4  # change of the elements' torque between rounds at convergence, over the peak
TIMES = 24  # relaxation times on the grid


class SlowFit(Protocol):
    """Result of a fit of a hysteresis model; see `fits.registry.Fitted`."""

    @property
    def model(self) -> HysteresisModel:
        """The model."""
        ...

    @property
    def initial_torque(self) -> InitialTorque:
        """The torque with which all curves begin [N·m]; or "measured"."""
        ...


def rate_of(model: HysteresisModel) -> Rate:
    """Returns the rate-dependent part of a fitted model."""
    if not isinstance(model, Viscoelastic):
        return "none"
    return "relaxing" if model.relaxation_stiffness > 0 else "viscous"


def fit_beside_rate(
    curves: Sequence[Curve],
    rate: Rate,
    fit: Callable[[Sequence[Curve]], SlowFit],
    quick: Callable[[Sequence[Curve]], SlowFit],
) -> tuple[Viscoelastic, InitialTorque]:
    """Fits a hysteresis model and the rate-dependent elements beside it, in turn.

    Each round fits the hysteresis model to the torque less that of the elements, and then solves
    for the elements beside the derivatives of the torque with respect to the model's parameters, so
    that torque that the model can describe as well does not count (variable projection, Golub and
    Pereyra 1973). The relaxation time is refined from the best one of a grid. Dampings and
    stiffnesses are at least 0; a Maxwell element that lowers the error by less than the cost of its
    parameters (the Bayesian information criterion) is left out.

    Args:
        curves: Measured curves, with times.
        rate: "viscous", a dashpot, or "relaxing", a Maxwell element beside it.
        fit: Fit of the hysteresis model to curves, for the last round.
        quick: The same with less effort, for the rounds before.
    """
    peak = max(float(np.abs(curve.torque).max()) for curve in curves)
    times = _times(curves) if rate == "relaxing" else np.empty(0)
    rest, slow = list(curves), quick(curves)
    found, before = Viscoelastic(model=slow.model), np.zeros(sum(one.angle.size for one in curves))
    for _ in range(ROUNDS):
        found = _with_elements(slow.model, slow.initial_torque, curves, times)
        torques = [_torque(found, curve) for curve in curves]
        now = np.concatenate(torques)
        if np.abs(now - before).max() <= CONVERGED * peak:
            break
        before = now
        rest = [
            replace(curve, torque=curve.torque - torque)
            for curve, torque in zip(curves, torques, strict=True)
        ]
        slow = quick(rest)
    slow = fit(rest)
    return replace(found, model=slow.model), slow.initial_torque


def _times(curves: Sequence[Curve]) -> Array:
    """Returns the relaxation times that curves can show [s]: from two samples to half a curve."""
    steps = [np.median(np.diff(times_of(curve))) for curve in curves]
    longest = max(float(np.ptp(times_of(curve))) for curve in curves)
    return np.geomspace(2 * min(steps), longest / 2, TIMES)


def _with_elements(
    model: HysteresisModel, start: InitialTorque, curves: Sequence[Curve], times: Array
) -> Viscoelastic:
    """Returns the model beside the elements that best explain its residual."""
    rest = -torque_errors(model, start, curves)
    if not np.isfinite(rest).all():
        return Viscoelastic(model=model)
    slopes = tangent(coordinates_of(model, start, fitted_start=True), curves)
    basis = independent(slopes)

    def beside(columns: Array) -> Array:
        return columns - basis @ (basis.T @ columns)

    dashpot = Viscoelastic(model=model, damping=1.0)
    velocity = np.concatenate([_torque(dashpot, curve) for curve in curves])[:, None]
    rest = beside(rest)
    (damping,), least = nnls(beside(velocity), rest)
    found = Viscoelastic(model=model, damping=float(damping))
    if times.size == 0:
        return found

    def solved(time: float) -> tuple[Array, float]:
        element = Viscoelastic(model=model, relaxation_stiffness=1.0, relaxation_time=time)
        torque = np.concatenate([_torque(element, curve) for curve in curves])
        return nnls(beside(np.column_stack([velocity, torque])), rest)

    best = int(np.argmin([solved(time)[1] for time in times.tolist()]))
    near = np.log(times[[max(best - 1, 0), min(best + 1, times.size - 1)]])
    closer: Any = minimize_scalar(
        lambda log: solved(math.exp(log))[1], bounds=near, method="bounded"
    )
    time = math.exp(closer.x)
    (damping, stiffness), loss = solved(time)
    if least <= loss * price(2, rest.size) or stiffness == 0:
        return found
    return Viscoelastic(
        model=model,
        damping=float(damping),
        relaxation_stiffness=float(stiffness),
        relaxation_time=time,
    )


def _torque(model: Viscoelastic, curve: Curve) -> Array:
    return model.rate_torque(curve.angle, times_of(curve))
