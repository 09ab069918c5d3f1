"""`fit_curves`: a model from measured curves, by a named method and several seeded trials."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, TypeVar, cast

import numpy as np
from joblib import Parallel, delayed

from ..arrays import Array
from ..checks import check_seed
from ..checks import workers as check_workers
from ..errors import InputError
from ..hysteresis.jiles_atherton.model import PARAMETERS
from ..published import LI_BOUNDS
from .corrections.corrections import Corrected, Corrections, corrected
from .data.curves import Curve, Curves, turns_back
from .fit import Fit, Trial, judged_fit
from .fits.certified import paper_model
from .fits.magnetic import FORMS, magnetic_fit
from .fits.objective import FEWEST_SAMPLES, CurveObjective, InitialTorque, nrmse, torque_errors
from .fits.parameters import FREE, Constraints
from .fits.registry import Fitted, fit_model
from .judging.coverage import Coverage
from .methods import DEFAULT_MODEL, Magnetic, Method, Search, check_together, method_of
from .swarms.variants import OPTIMIZERS

Result = TypeVar("Result")
NONE = Corrections()


def run_threads(
    calls: Sequence[Callable[[], Result]],
    workers: int,
    on_result: Callable[[Result], None] | None = None,
) -> tuple[list[Result], bool]:
    """Makes all calls; returns the results in any order, and whether Ctrl-C ended the calls early.

    The calls spend nearly all of their time in kernels that release the GIL. `on_result` gets each
    result as soon as it is known. Ctrl-C before the first result raises KeyboardInterrupt.
    """
    finished: list[Result] = []
    parallel = Parallel(
        n_jobs=min(workers, len(calls)), prefer="threads", return_as="generator_unordered"
    )
    try:
        for result in cast(Iterable[Result], parallel(delayed(call)() for call in calls)):
            finished.append(result)
            if on_result is not None:
                on_result(result)
    except KeyboardInterrupt:
        if not finished:
            raise
        return finished, True
    return finished, False


def fit_curves(
    curves: Sequence[Curve],
    *,
    model: str = DEFAULT_MODEL,
    method: str | Method = "certified",
    corrections: Corrections = NONE,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    initial_torque: InitialTorque | None = None,
    seed: int = 0,
    workers: int = -1,
    needed: Coverage | None = None,
    on_trial: Callable[[Trial], None] | None = None,
) -> Fit:
    """Fits one hysteresis model to measured curves by one method.

    Trials are independent, run in parallel on all cores, and depend only on `seed` and their
    index: the result is the same for any number of workers. Ctrl-C keeps the finished trials.
    Options that the method would ignore are refused. Of more than 50,000 samples to fit, `thinned`
    picks the samples of the fit; a remark then says so, and errors are those of all samples.

    Args:
        curves: The measurements; those with role "predict" are kept out of the fit and tested.
        model: "jiles-atherton", "asymmetric" (the same beside a polynomial), "bouc-wen",
            "prandtl-ishlinskii", "preisach", "hinged-stops", "dahl" or "duhem"; `select` chooses
            among them.
        method: `Certified`, `Search` or `Magnetic` with their options; or the name of a method with
            its usual options: "certified" (ours: least squares that return certified models only);
            or, for "jiles-atherton" only, a name of `Search`, such as "sa-pso", or "magnetic"
            (magnetization over a field, in the form that fits best; not certified).
        corrections: Corrections of the curves, and terms that are fitted beside the model.
        fixed: Parameters that keep a value, such as {"c": 1.2}. Names and units are those of the
            model that the method returns: angles of Jiles-Atherton are degrees, and radians with
            the method "magnetic". "weights" means all weights, and "weights[3]" a single weight.
            Values hold at the pressure of the curves.
        bounds: Lower and upper bound of parameters, such as {"k": (1, 50)}, in place of the bounds
            of the search; an infinite bound leaves the side open.
        initial_torque: The torque with which each Jiles-Atherton curve begins: a number [N·m], by
            default 0 as in a first-order curve; "measured", the first sample of each curve; or
            "identified", one torque for all curves. Fits of other models always identify it.
        seed: Seed of all random numbers.
        workers: The number of threads; -1 uses all cores.
        needed: Coverage of the intended motions, as `motion_coverage` returns it; the verdict and
            the remarks then state where the curves fall short of it.
        on_trial: Function that gets each trial as it finishes, in any order.

    Returns:
        The best trial's model, its errors, and reasons to doubt it.
    """
    method = method_of(method)
    check_together(method, model, corrections, initial_torque)
    constraints = Constraints(fixed or {}, bounds or {})
    constraints.check(model, corrections.beside, method.name)
    check_seed(seed)
    check_workers(workers)
    starts = initial_torque is not None and model == DEFAULT_MODEL
    start: dict[str, Any] = {"initial_torque": initial_torque} if starts else {}
    ready = prepared(curves, model, corrections, start, seed, constraints)
    measured = ready.measured
    if model != DEFAULT_MODEL or corrections.beside or isinstance(method, Magnetic):
        refuse_weights(measured)

    def run(index: int, child: np.random.SeedSequence) -> Trial:
        rng = np.random.default_rng(child)
        if isinstance(method, Search):
            found = searched(measured, method, start, rng, constraints)
        elif isinstance(method, Magnetic):
            options = {"budget": method.budget, "constraints": constraints, **start}
            found = magnetic_fit(measured, FORMS[index], rng, **options)
        else:
            options = {**method.options, **start, **corrections.beside}
            found = fit_model(model, measured, rng, constraints=constraints, **options)
        own = nrmse(torque_errors(found.model, found.initial_torque, measured), measured)
        return Trial(index=index, nrmse=own, **vars(found))

    seeds = np.random.SeedSequence(seed).spawn(method.trials)
    calls = [partial(run, index, child) for index, child in enumerate(seeds)]
    finished, interrupted = run_threads(calls, workers, on_trial)
    return judged_fit(
        ready,
        corrections,
        model,
        method,
        finished,
        needed,
        constraints=constraints,
        fitted_start=fits_start(model, initial_torque),
        interrupted=interrupted,
    )


def searched(
    curves: Sequence[Curve],
    method: Search,
    start: dict[str, Any],
    rng: np.random.Generator,
    constraints: Constraints = FREE,
) -> Fitted:
    """Runs an optimizer once on the Jiles-Atherton parameters, in the paper's search bounds."""
    goal = CurveObjective(curves, loss=method.objective, normalize=method.normalize, **start)
    box = [
        constraints.box(name, ends, 0.0 if name in ("Ms", "a", "k") else -np.inf)
        for name, ends in zip(PARAMETERS, LI_BOUNDS, strict=True)
    ]
    if goal.initial_torque == "identified":
        box.append((-goal.peak, goal.peak))
    low, high = np.array(box).T
    free = low < high

    def loss(positions: Array) -> Array:
        rows = np.tile(low, (len(positions), 1))
        rows[:, free] = positions
        return goal(rows)

    pairs = tuple(one for one in box if one[0] < one[1])
    run = OPTIMIZERS[method.name](loss, pairs, rng=rng, **method.options)
    row = low.copy()
    row[free] = run.x
    first = float(row[5]) if goal.initial_torque == "identified" else goal.initial_torque
    history = tuple(map(float, run.history))
    return Fitted(paper_model(row[:5]), first, float(run.fun), goal.evaluations, history=history)


def fits_start(model: str, initial_torque: InitialTorque | None) -> bool:
    """Returns whether the fit of a model chooses the torque with which the curves begin."""
    return model != DEFAULT_MODEL or initial_torque == "identified"


def prepared(
    curves: Sequence[Curve],
    model: str,
    corrections: Corrections,
    start: dict[str, Any],
    seed: int,
    constraints: Constraints,
) -> Corrected:
    """Returns corrected curves: all of them, and those to fit.

    Tare and softening are those of the certified fit of `model`, with the options `start`.
    """
    family = Curves(curves)
    _refuse_unusable(family.fitted())
    if corrections.average_cycles:
        raise InputError(
            "average_cycles is True, and only `identify` averages: give averaged_cycles(curves)"
        )

    def fitted(some: Curves) -> Fitted:
        rng = np.random.default_rng(seed)
        return fit_model(model, some, rng, constraints=constraints, **start, **corrections.beside)

    return corrected(family, corrections, fitted)


def _refuse_unusable(measured: Curves) -> None:
    """Refuses too few samples to fit, and curves that never turn back."""
    samples = CurveObjective(measured).torque.size
    if samples < FEWEST_SAMPLES:
        raise InputError(
            f"the fitted curves have {samples} samples in all: give at least {FEWEST_SAMPLES}"
        )
    if not any(map(turns_back, measured)):
        raise InputError(
            "no curve turns back, and one direction of motion alone does not show the loss: "
            "measure the return of at least one curve too"
        )


def refuse_weights(curves: Sequence[Curve]) -> None:
    """Refuses curves whose weights differ, for fits that ignore weights."""
    weights = [curve.weight for curve in curves]
    if min(weights) < max(weights):
        raise InputError(
            f"the curves have weights from {min(weights):g} to {max(weights):g}: only fits of the "
            "model 'jiles-atherton' without rate and play weigh curves; remove the weights"
        )
