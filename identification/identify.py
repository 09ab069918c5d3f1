"""`identify`: from measured curves to a model, by a named method and several seeded trials."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, cast

import numpy as np

from ..arrays import Array
from ..checks import at_least
from ..checks import workers as check_workers
from ..errors import InputError
from ..hysteresis.around.viscoelastic import Viscoelastic
from ..hysteresis.protocol import HysteresisModel
from ..published import LI_BOUNDS
from ._threads import run_threads
from .coverage import Coverage, coverage, shortfalls
from .curves import Curve, Curves
from .diagnostics import diagnostics, turns_back
from .ensemble import LEVEL, NESTED, Ensemble, drawn, ensemble
from .fits.play import Play, play_of
from .fits.rate import Rate, rate_of
from .fits.registry import FITS, Fitted, fit_model
from .objective import FEWEST_SAMPLES, CurveObjective, InitialTorque, Loss, Normalize
from .optimizers.registry import OPTIMIZERS
from .options import DEFAULT_MODEL, check_corrections, check_method, check_options
from .prediction import nrmse, predicted, torque_errors
from .residual.loop_work import refuse_driven
from .residual.verdict import NOT, Judgement, judge
from .selection import Candidate, Choice, choose
from .softening import Count, Softening, Softens, found_softening, settled
from .tare import Tare, found_tare, tared
from .thinning import thinned, thinning_note
from .trials import Trial, fit_trial, optimizer_trial
from .uncertainty.uncertainty import Uncertainty, uncertainty

SURELY, NEAR = 5.0, 0.02  # tolerance in deviations of the noise, and as a share of the peak
TRIALS = 30  # number of runs of an optimizer, as in Li et al. 2022


@dataclass(frozen=True, kw_only=True)
class Fit:
    """Result of `identify`.

    Attributes:
        model: The best trial's model; if it is safe at the fitted angles only, its torque is
            constant outside them.
        model_name: The name of the model.
        method: The name of the method that found it.
        initial_torque: The torque with which all curves begin [N·m]; or "measured": each begins
            with its first sample.
        fitness: Eq. (7) of Li et al. 2022 on the fitted curves.
        nrmse: Error sqrt(mean((Tc - Tm)^2)) / max|Tm| on the fitted curves.
        prediction_errors: The largest |Tc - Tm| [N·m] on each curve with role "predict"; infinity
            where the model meets its pole.
        trials: Every finished trial, by index; with method "auto" that of the chosen model.
        curves: The measured curves, those with role "predict" too, less the tare, and with the
            torques that they would have had at the end of the measurement.
        diagnostics: Reasons to doubt the model, as sentences; empty if there are none.
        why: The reason of the choice that method "auto" made, as a sentence; else empty.
        candidates: All models that method "auto" tried, the best prediction first; else empty.
        ensemble: Candidates that predict left-out curves nearly as well as the best, of which
            `band` is made; None unless the method is "auto", or where all meet a pole.
        interrupted: Whether Ctrl-C ended it before all trials, or models, were done.
        fitted_start: Whether the initial torque was fitted too.
        coverage: Range, reversals, rates and cycles of the fitted curves.
        shortfalls: Requirements of the intended motions that the curves do not cover, as sentences.
        tare: Offset of the torque sensor that was subtracted from the curves [N·m].
        softening: Change of the torque over the cycles that was removed from the curves; None if
            none was.
        judgement: Verdict on the model by its residual; None where the model meets its pole on the
            curves.
    """

    model: HysteresisModel
    model_name: str
    method: str
    initial_torque: InitialTorque
    fitness: float
    nrmse: float
    prediction_errors: dict[str, float]
    trials: tuple[Trial, ...]
    curves: Curves = field(repr=False, compare=False)
    diagnostics: tuple[str, ...] = ()
    why: str = ""
    candidates: tuple[Candidate, ...] = ()
    ensemble: Ensemble | None = None
    interrupted: bool = False
    fitted_start: bool = False
    judgement: Judgement | None = field(default=None, compare=False)
    coverage: Coverage | None = None
    shortfalls: tuple[str, ...] = ()
    tare: float = 0.0
    softening: Softening | None = None

    @property
    def evaluations(self) -> int | None:
        """Model evaluations of all trials together; None where the fit does not count."""
        counts = [trial.evaluations for trial in self.trials]
        return None if None in counts else sum(cast(list[int], counts))

    @property
    def agreed(self) -> int | None:
        """How many starts of the best trial ended at its model; None where it has one start."""
        return min(self.trials, key=lambda trial: (trial.loss, trial.index)).agreed

    def predict(self, curve: Curve) -> Array:
        """Returns the torque [N·m] along a curve, begun as the fitted ones; infinite at a pole."""
        return predicted(self.model, self.initial_torque, curve)

    def band(self, curve: Curve, level: float = LEVEL) -> tuple[Array, Array]:
        """Returns the ends of a band of the torque along a curve [N·m], shape (samples,) each.

        The band of `uncertainty` is valid if the kind of model is right; this one also covers the
        differences between kinds of model that the curves allow, see `Ensemble.band`.

        Args:
            curve: Motion; its torque is used only where the fit began with the measured one.
            level: Share of the samples that the band is to contain, between 0 and 1.

        Raises:
            InputError: The method is not "auto", or see `Ensemble.band`.
        """
        if self.ensemble is None:
            raise InputError(
                f"the method is {self.method!r}, which tried one model: a band over models needs "
                "method 'auto'; use uncertainty().band(curve) for that of the parameters"
            )
        return self.ensemble.band(curve, level)

    @property
    def verdict(self) -> str:
        """Whether the model describes the curves, as a phrase; see `residual.verdict`."""
        return NOT if self.judgement is None else self.judgement.verdict

    def uncertainty(self, *, samples: int = 0, seed: int = 0) -> Uncertainty:
        """Returns the uncertainty of the parameters and of the torque of the model.

        Args:
            samples: Number of models to draw, as fits to noisy repetitions of the curves would give
                them; with method "auto" of all kinds in the ensemble, by their weight.
            seed: Seed of their noise.

        Raises:
            InputError: See `identification.uncertainty`.
        """
        found = uncertainty(
            self.model,
            self.curves,
            initial_torque=self.initial_torque,
            fitted_start=self.fitted_start,
            samples=0 if self.ensemble else samples,
            seed=seed,
        )
        if self.ensemble is None:
            return found
        models = drawn(self.ensemble, self.curves, self.initial_torque, samples, seed)
        return replace(found, samples=models)


def identify(
    curves: Sequence[Curve],
    *,
    model: str | None = None,
    method: str = "certified",
    objective: Loss | None = None,
    normalize: Normalize | None = None,
    initial_torque: InitialTorque | None = None,
    trials: int | None = None,
    seed: int = 0,
    workers: int = -1,
    on_trial: Callable[[Trial], None] | None = None,
    needed: Coverage | None = None,
    tare: Tare = 0.0,
    rate: Rate = "none",
    play: Play = "none",
    softening: Softens = "none",
    **options: Any,
) -> Fit:
    """Identifies a hysteresis model from first-order transition curves.

    Trials are independent, run in parallel on all cores, and depend only on `seed` and their
    index: the result is the same for any number of workers. Ctrl-C keeps the finished trials, or
    with method "auto" the finished models.
    An option that the method would ignore is refused. Of more than 50,000 samples to fit, `thinned`
    picks those that the fit uses; the diagnostics then say so, and errors are those of all samples.

    Args:
        curves: The measurements; those with role "predict" are kept out of the fit and tested.
        model: "jiles-atherton" (by default), "asymmetric" (the same beside a polynomial),
            "bouc-wen", "prandtl-ishlinskii", "preisach" or "hinged-stops".
        method: "certified" (ours: least squares, can only return certified models); "auto" (the
            simplest model that predicts well curves left out of its certified fit); or, for
            "jiles-atherton" only, a swarm as published: "pso", "sa-pso", "mpso",
            "rank-distance-mpso"; or a baseline of other libraries: "de", "dual-annealing",
            "nelder-mead", "ga", "cma-es" (the last two need the extra `compare`). Swarms and
            baselines search the bounds of the paper's Table 1.
        objective: Loss of `CurveObjective` that a swarm or baseline minimizes; by default "nrmse".
        normalize: Whether the objective divides errors by the largest torque of the "family" (by
            default) or of each "curve".
        initial_torque: The torque with which each Jiles-Atherton curve begins: a number [N·m], by
            default 0 as in a first-order curve; "measured", its own first sample; or "identified",
            one for all. The fits of the other models always identify it.
        trials: The number of runs from different random numbers; by default 1 for "certified" and
            30, as in the paper, for swarms and baselines.
        seed: Seed of all random numbers.
        workers: The number of threads; -1 uses all cores.
        on_trial: Function that gets each trial as it finishes, in any order.
        tare: Offset of the torque sensor [N·m], which is subtracted from all curves; "zero" is the
            mean torque with which they begin, "fitted" the one that the certified fit prefers (of
            Jiles-Atherton with method "auto").
        rate: Rate-dependent part of the torque that is fitted beside the certified model:
            nothing ("none"), a dashpot ("viscous"), or a dashpot and a Maxwell element
            ("relaxing"); the model is then `Viscoelastic`, and the curves need times.
        play: Whether the certified model is fitted behind a gap in the transmission ("fitted"), at
            which contact opens at zero torque, or without one ("none"); the model is then
            `Backlash`, if a gap was found.
        softening: Whether a change of the torque over the cycles is estimated with the certified
            fit, as the tare is, and removed from the curves ("fitted"), or there is none ("none").
            The model is then that of the end of the measurement.
        needed: Coverage of the intended motions, as `motion_coverage` returns it; the verdict and
            the diagnostics then state where the curves fall short of it.
        **options: Options of the method (`swarm_size`, `temperature`, `budget`,
            `max_evaluations`, ...).

    Returns:
        The best trial's model, its errors, and reasons to doubt it.

    Raises:
        InputError: Unknown model, method or option, one that the method would ignore, no curve to
            fit, or a number out of its range.
    """
    check_method(model, method)
    check_options(model, method, objective, normalize, initial_torque, trials, rate, play, options)
    check_corrections(tare, softening)
    at_least("seed", seed, 0)
    check_workers(workers)
    family = Curves(curves)
    measured = thinned(_measured(family))
    refuse_driven(measured)
    name = model or DEFAULT_MODEL
    if method == "auto" and len(measured) == 1:
        initial_torque = "identified"  # a record may begin anywhere, unlike first-order curves
    starts = initial_torque is not None and name == DEFAULT_MODEL
    start = {"initial_torque": initial_torque} if starts else {}
    beside: dict[str, Any] = {} if rate == "none" else {"rate": rate}
    beside |= {} if play == "none" else {"play": play}

    def fitted(curves: Curves) -> Fitted:
        return fit_model(name, curves, np.random.default_rng(seed), **start, **beside)

    family, measured, offset, change = _corrected(family, measured, tare, softening, fitted)
    if method == "auto" or name != DEFAULT_MODEL or beside:
        _refuse_weights(measured)

    def fits_start(name: str) -> bool:
        return name != DEFAULT_MODEL or initial_torque == "identified"

    if method == "auto":
        ways = dict.fromkeys(FITS, beside) | {DEFAULT_MODEL: start | beside}
        found = _automatic(family, measured, ways, fits_start, needed, seed, workers, on_trial)
        return _completed(found, offset, change, rate, play, softening)
    if method == "certified":
        run = partial(fit_trial, measured, name, options | start | beside)
    else:
        goal = {"loss": objective or "nrmse", "normalize": normalize or "family", **start}
        run = partial(optimizer_trial, measured, method, goal, options)
    trials = trials or {"certified": 1}.get(method, TRIALS)
    seeds = np.random.SeedSequence(seed).spawn(trials)
    calls = [partial(run, index, child) for index, child in enumerate(seeds)]
    finished, interrupted = run_threads(calls, workers, on_trial)
    found = _fit(
        family,
        name,
        method,
        finished,
        needed,
        fits_start(name),
        interrupted=interrupted,
        searched=method in OPTIMIZERS and objective != "robust" and normalize != "curve",
    )
    return _completed(found, offset, change, rate, play, softening)


def _corrected(
    family: Curves,
    measured: Curves,
    tare: Tare,
    softening: Softens,
    fitted: Callable[[Curves], Fitted],
) -> tuple[Curves, Curves, float, Softening | None]:
    """Returns all curves and those to fit without tare and softening, and both corrections."""
    offset = found_tare(measured, tare, lambda curves: fitted(curves).loss)
    family, measured = tared(family, offset), tared(measured, offset)
    count = Count(family)
    change = found_softening(measured, count, fitted) if softening == "fitted" else None
    if change is not None:
        family, measured = settled(family, change, count), settled(measured, change, count)
    return family, measured, offset, change


def _completed(
    found: Fit, tare: float, change: Softening | None, rate: Rate, play: Play, softening: Softens
) -> Fit:
    """Returns a fit with its corrections, and remarks on terms that were fitted but not found."""
    remarks = []
    if softening == "fitted" and change is None:
        remarks.append("no change from cycle to cycle was found: leave --softening out")
    if change is not None and not change.is_settled:
        remarks.append(
            f"the torque still changes at the end of {change.measured:.2g} cycles, so that the "
            f"steady one, {change.steady:.3g} times the last, is extrapolated: measure more cycles"
        )
    if play == "fitted" and play_of(found.model) == "none":
        remarks.append("no gap was found: leave --play out")
    if isinstance(found.model, Viscoelastic) and rate_of(found.model) == "viscous":
        if found.model.damping == 0:
            remarks.append("the torque was not found to depend on the rate: leave --rate out")
        elif rate == "relaxing":
            remarks.append("no relaxation was found beside the dashpot: use --rate viscous")
    said = (*found.diagnostics, *remarks)
    return replace(found, tare=tare, softening=change, diagnostics=said)


def _automatic(
    family: Curves,
    measured: Curves,
    ways: dict[str, dict[str, Any]],
    fits_start: Callable[[str], bool],
    needed: Coverage | None,
    seed: int,
    workers: int,
    on_trial: Callable[[Trial], None] | None,
) -> Fit:
    """Returns the fit of the model that predicts left-out data best, with the ensemble."""
    choice = choose(measured, seed=seed, workers=workers, options=ways)
    name, trial = choice.chosen.name, _chosen_trial(choice.chosen)
    if on_trial is not None:
        on_trial(trial)
    found = _fit(
        family, name, "auto", [trial], needed, fits_start(name), choice, choice.interrupted
    )
    if found.judgement is None:
        return found
    members = ensemble(
        choice.candidates,
        measured,
        found.judgement.noise,
        seed=seed,
        options=ways,
        fitted_start=fits_start,
    )
    return replace(found, ensemble=members)


def _measured(curves: Curves) -> Curves:
    """Returns the curves to fit; reports unusable ones before any thread starts."""
    measured = curves.fitted()
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
    return measured


def _refuse_weights(curves: Sequence[Curve]) -> None:
    weights = [curve.weight for curve in curves]
    if min(weights) < max(weights):
        raise InputError(
            f"the curves have weights from {min(weights):g} to {max(weights):g}: only fits of the "
            "model 'jiles-atherton' without rate and play weigh curves; remove the weights"
        )


def _chosen_trial(chosen: Candidate) -> Trial:
    assert chosen.model is not None  # a candidate without a fit is never chosen
    return Trial(
        index=0,
        model=chosen.model,
        initial_torque=chosen.initial_torque,
        nrmse=chosen.fit_nrmse,
        loss=chosen.fit_nrmse,
        evaluations=None,
    )


def _begins_elsewhere(start: InitialTorque, curves: Curves, noise: float) -> list[str]:
    """Returns a remark if the curves begin at another torque than the model."""
    first = curves.start_torque
    if isinstance(start, str) or abs(first - start) <= max(SURELY * noise, NEAR * curves.peak):
        return []
    return [
        f"the curves begin at {first:.3g} N·m, and the model at {start:.3g} N·m: let it begin "
        "where they do (--initial-torque identified); or, if the sensor has an offset, take it off "
        "(--tare fitted)"
    ]


def _fit(
    curves: Curves,
    name: str,
    method: str,
    trials: list[Trial],
    needed: Coverage | None,
    fitted_start: bool,
    choice: Choice | None = None,
    interrupted: bool = False,
    searched: bool = False,
) -> Fit:
    measured = curves.fitted()
    best = min(trials, key=lambda trial: (trial.loss, trial.index))
    errors = {
        curve.name: float(np.abs(torque_errors(best.model, best.initial_torque, [curve])).max())
        for curve in curves.held_out()
    }
    bounds = LI_BOUNDS if method in OPTIMIZERS else None
    score, note = best.nrmse, thinning_note(measured)
    if note:
        score = nrmse(torque_errors(best.model, best.initial_torque, measured), measured)
    said = diagnostics(best.model, score, measured, bounds)
    covered = coverage(measured)
    short = shortfalls(covered, needed) if needed else ()
    beyond = bool(short) if needed else covered.nesting < NESTED
    judged = judge(
        best.model,
        best.initial_torque,
        measured,
        fitted_start=fitted_start,
        beyond=beyond,
        searched=searched,
    )
    if choice and choice.unneeded and judged:
        remarks = (choice.unneeded, *judged.remarks)
        judged = replace(judged, verdict=NOT, remarks=remarks)
    said = (*said, *(judged.remarks if judged else ()), *short)
    if judged and not fitted_start:
        said = (*said, *_begins_elsewhere(best.initial_torque, measured, judged.noise.deviation))
    return Fit(
        model=best.model,
        model_name=name,
        method=method,
        initial_torque=best.initial_torque,
        fitness=score / float(np.sqrt(sum(curve.angle.size for curve in measured))),
        nrmse=score,
        prediction_errors=errors,
        trials=tuple(sorted(trials, key=lambda trial: trial.index)),
        curves=curves,
        diagnostics=(f"{note}, in the fit; errors are those of all", *said) if note else said,
        why=choice.why if choice else "",
        candidates=choice.candidates if choice else (),
        interrupted=interrupted,
        fitted_start=fitted_start,
        judgement=judged,
        coverage=covered,
        shortfalls=tuple(short),
    )
