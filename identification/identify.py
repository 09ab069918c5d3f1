"""`identify`: from measured curves to a model, by a named method and several seeded trials."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, cast

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from ..errors import InputError, at_least, unknown_name
from ..hysteresis import Held, JilesAtherton
from .baselines import BASELINES
from .certified import certified_fit
from .curves import Curve
from .mpso import mpso
from .objective import CurveObjective
from .pso import pso
from .rank_distance_mpso import rank_distance_mpso
from .remarks import remarks
from .sa_pso import sa_pso

# Table 1 of Li et al. 2022: Ms [N·m], a [deg], alpha [deg/(N·m)], c, k [deg].
PAPER_BOUNDS = ((1.0, 100.0), (1.0, 5000.0), (-10.0, 10.0), (-10.0, 10.0), (1.0, 2000.0))
SWARMS = {
    "pso": pso,
    "sa-pso": sa_pso,
    "mpso": mpso,
    "rank-distance-mpso": rank_distance_mpso,
}
METHODS = ("certified", *SWARMS, *BASELINES)
BASELINE_EVALUATIONS = 5000  # as many as the paper's swarms
FEWEST_SAMPLES = 10  # for five parameters
MODELS = ("jiles-atherton",)


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One independent run of a method.

    Attributes:
        index: its number, which fixes its random numbers.
        parameters: Ms, a, alpha, c, k in degrees.
        held: the range [rad] outside which the certified fit needs its torque held, if any.
        nrmse: sqrt(mean((Tc - Tm)^2)) / max|Tm| on the fitted curves.
        evaluations: how often the model was evaluated on all curves.
        history: best score so far, per iteration (eq. (7) for the swarms, NRMSE for "certified").
    """

    index: int
    parameters: tuple[float, ...]
    held: tuple[float, float] | None = None
    nrmse: float
    evaluations: int
    history: tuple[float, ...] = field(repr=False)


@dataclass(frozen=True, kw_only=True)
class Fit:
    """What `identify` found.

    Attributes:
        model: the best trial's model, held outside the fitted angles if it is safe inside only.
        method: the name it was found by.
        fitness: eq. (7) of Li et al. 2022 on the fitted curves.
        nrmse: sqrt(mean((Tc - Tm)^2)) / max|Tm| on the fitted curves.
        prediction_errors: largest |Tc - Tm| [N·m] on each curve with role "predict"; infinity where
            the model meets its pole.
        trials: every finished trial, by index.
        remarks: what speaks against trusting the model, as sentences; empty if nothing does.
        interrupted: whether Ctrl-C ended it before all trials were done.
    """

    model: JilesAtherton | Held
    method: str
    fitness: float
    nrmse: float
    prediction_errors: dict[str, float]
    trials: tuple[Trial, ...]
    remarks: tuple[str, ...] = ()
    interrupted: bool = False

    @property
    def evaluations(self) -> int:
        """Model evaluations of all trials together."""
        return sum(trial.evaluations for trial in self.trials)


def identify(
    curves: Sequence[Curve],
    *,
    model: str = "jiles-atherton",
    method: str = "certified",
    trials: int | None = None,
    seed: int = 0,
    workers: int = -1,
    on_trial: Callable[[Trial], None] | None = None,
    **options: Any,
) -> Fit:
    """Identifies a hysteresis model from first-order transition curves.

    Trials are independent, run in parallel on all cores, and depend only on `seed` and their
    index: the result is the same for any number of workers. Ctrl-C keeps the finished trials.

    Args:
        curves: the measurements; those with role "predict" are kept out of the fit and tested.
        model: "jiles-atherton".
        method: "certified" (ours: least squares, can only return certified models); a swarm as
            published: "pso", "sa-pso", "mpso", "rank-distance-mpso"; or a baseline of other
            libraries: "de", "dual-annealing", "nelder-mead", "ga", "cma-es" (the last two need the
            extra `compare`). All but ours search the bounds of the paper's Table 1.
        trials: number of runs from different random numbers; by default 1 for "certified" and 30,
            as in the paper, for the others.
        seed: fixes all random numbers.
        workers: threads; -1 uses all cores.
        on_trial: called with each trial as it finishes, in any order.
        **options: passed to the method (`swarm_size`, `temperature`, `budget`,
            `max_evaluations`, ...).

    Raises:
        InputError: unknown model or method, no curve to fit, or a number out of its range.
    """
    if model not in MODELS:
        raise unknown_name("model", model, MODELS)
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    if trials is None:
        trials = 1 if method == "certified" else 30
    at_least("trials", trials, 1)
    at_least("seed", seed, 0)
    if workers == 0:
        raise InputError("workers is 0: use a number of threads, or -1 for all cores")
    measured = [curve for curve in curves if curve.role == "fit"]
    samples = CurveObjective(measured).torque.size  # reports unusable data before any thread starts
    if samples < FEWEST_SAMPLES:
        raise InputError(
            f"the fitted curves have {samples} samples in all: give at least {FEWEST_SAMPLES}"
        )
    run = partial(_run_trial, measured, method, options)
    seeds = np.random.SeedSequence(seed).spawn(trials)
    finished: list[Trial] = []
    interrupted = False
    try:
        jobs = (delayed(run)(index, child) for index, child in enumerate(seeds))
        # Threads: nearly all the time is spent in kernels that release the GIL.
        parallel = Parallel(
            n_jobs=min(workers, trials), prefer="threads", return_as="generator_unordered"
        )
        for trial in cast(Iterable[Trial], parallel(jobs)):
            finished.append(trial)
            if on_trial is not None:
                on_trial(trial)
    except KeyboardInterrupt:
        if not finished:
            raise
        interrupted = True
    return _best(curves, method, finished, interrupted)


def bare(model: JilesAtherton | Held) -> JilesAtherton:
    """Returns the Jiles-Atherton model inside a fitted one."""
    return cast(JilesAtherton, model.model) if isinstance(model, Held) else model


def paper_model(parameters: Sequence[float] | NDArray[np.float64]) -> JilesAtherton:
    """Returns the model of one parameter row (Ms, a, alpha, c, k) in degrees, whatever its c."""
    Ms, a, alpha, c, k = (float(value) for value in parameters)
    return JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg", allow_active=c < 1)


def _run_trial(
    curves: Sequence[Curve],
    method: str,
    options: dict[str, Any],
    index: int,
    seed: np.random.SeedSequence,
) -> Trial:
    rng = np.random.default_rng(seed)
    if method == "certified":
        fit = certified_fit(curves, rng=rng, **options)
        parameters, evaluations, history = fit.parameters, fit.evaluations, fit.history
        held = fit.held
    else:
        held = None
        objective = CurveObjective(curves)
        if method in SWARMS:
            result = SWARMS[method](objective, PAPER_BOUNDS, rng=rng, **options)
        else:
            options = {"max_evaluations": BASELINE_EVALUATIONS, **options}
            result = BASELINES[method](objective, PAPER_BOUNDS, rng=rng, **options)
        parameters, evaluations, history = result.x, objective.evaluations, result.history
    return Trial(
        index=index,
        parameters=tuple(map(float, parameters)),
        held=held,
        nrmse=float(CurveObjective(curves).nrmse(parameters)[0]),
        evaluations=evaluations,
        history=tuple(map(float, history)),
    )


def _best(curves: Sequence[Curve], method: str, trials: list[Trial], interrupted: bool) -> Fit:
    measured = [curve for curve in curves if curve.role == "fit"]
    best = min(trials, key=lambda trial: (trial.nrmse, trial.index))
    errors: dict[str, float] = {}
    for curve in curves:
        if curve.role == "predict":
            predicted = CurveObjective([curve]).responses(best.parameters)[0]
            worst = float(np.abs(predicted - curve.torque).max())
            errors[curve.name] = worst if np.isfinite(worst) else float("inf")
    model = paper_model(best.parameters)
    bounds = None if method == "certified" else PAPER_BOUNDS
    return Fit(
        model=Held(model=model, angle_range=best.held) if best.held else model,
        method=method,
        fitness=float(CurveObjective(measured)(best.parameters)[0]),
        nrmse=best.nrmse,
        prediction_errors=errors,
        trials=tuple(sorted(trials, key=lambda trial: trial.index)),
        remarks=remarks(model, best.nrmse, measured, bounds),
        interrupted=interrupted,
    )
