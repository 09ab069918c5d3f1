"""Independent trials of `fit_curves`: one fit, or one run of an optimizer."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult

from ..hysteresis.protocol import HysteresisModel
from ..published import LI_BOUNDS
from .curves import Curve
from .fits.beginning import paper_model
from .fits.magnetic import FORMS, magnetic_fit
from .fits.registry import Fitted, fit_model
from .objective import CurveObjective, InitialTorque
from .optimizers.registry import OPTIMIZERS
from .prediction import nrmse, torque_errors


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One independent run of a method.

    Attributes:
        index: The number of the trial, which determines its random numbers.
        model: The model that it found; if it is safe at the fitted angles only, its torque is
            constant outside them.
        initial_torque: The torque with which all curves begin [N·m]; or "measured": each begins
            with its first sample.
        nrmse: Error sqrt(mean((Tc - Tm)^2)) / max|Tm| on the fitted curves.
        loss: The objective that the method minimized: the NRMSE, or the one that was asked for.
        evaluations: How often the model ran on all curves; None where the fit does not count.
        agreed: How many runs from different starts of a certified fit ended at this model; None
            where it has one start.
        starts: How many runs there were; None likewise.
        history: The smallest objective so far, as the optimizer tells it; per iteration of a swarm.
    """

    index: int
    model: HysteresisModel
    initial_torque: InitialTorque
    nrmse: float
    loss: float
    evaluations: int | None
    agreed: int | None = None
    starts: int | None = None
    history: tuple[float, ...] = field(default=(), repr=False)


def fit_trial(
    curves: Sequence[Curve],
    model: str,
    options: dict[str, Any],
    index: int,
    seed: np.random.SeedSequence,
) -> Trial:
    """Runs the certified fit of a model once."""
    return _trial(fit_model(model, curves, np.random.default_rng(seed), **options), curves, index)


def magnetic_trial(
    curves: Sequence[Curve],
    initial_torque: InitialTorque,
    budget: int,
    index: int,
    seed: np.random.SeedSequence,
) -> Trial:
    """Fits one form of the Jiles-Atherton model of magnetics; `index` is its place in `FORMS`."""
    rng = np.random.default_rng(seed)
    found = magnetic_fit(curves, FORMS[index], rng, budget=budget, initial_torque=initial_torque)
    return _trial(found, curves, index)


def _trial(found: Fitted, curves: Sequence[Curve], index: int) -> Trial:
    return Trial(
        index=index,
        model=found.model,
        initial_torque=found.initial_torque,
        nrmse=nrmse(torque_errors(found.model, found.initial_torque, curves), curves),
        loss=found.loss,
        evaluations=found.evaluations,
        agreed=found.agreed,
        starts=found.starts,
    )


def optimizer_trial(
    curves: Sequence[Curve],
    method: str,
    goal: dict[str, Any],
    options: dict[str, Any],
    index: int,
    seed: np.random.SeedSequence,
) -> Trial:
    """Runs an optimizer once on the Jiles-Atherton parameters; `goal` is for `CurveObjective`."""
    objective = CurveObjective(curves, **goal)
    run = run_optimizer(objective, method, np.random.default_rng(seed), options)
    model, start = paper_model(run.x[:5]), objective.initial_torque
    start = float(run.x[5]) if start == "identified" else start
    return Trial(
        index=index,
        model=model,
        initial_torque=start,
        nrmse=nrmse(torque_errors(model, start, curves), curves),
        loss=float(run.fun),
        evaluations=objective.evaluations,
        history=tuple(map(float, run.history)),
    )


def run_optimizer(
    objective: CurveObjective, method: str, rng: np.random.Generator, options: dict[str, Any]
) -> OptimizeResult:
    """Minimizes the objective in the paper's search bounds by the optimizer `method`."""
    bounds = LI_BOUNDS
    if objective.initial_torque == "identified":
        bounds = (*bounds, (-objective.peak, objective.peak))
    return OPTIMIZERS[method](objective, bounds, rng=rng, **options)
