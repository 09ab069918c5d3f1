"""`select`: the kind of model that predicts best, and a band over those that are nearly as good."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import check_seed
from ..checks import workers as check_workers
from ..errors import InputError, unknown_name
from .corrections.corrections import Corrections, is_open
from .data.curves import Curve, Curves
from .data.files import Motion
from .data.parts import Question, questions
from .fit import Fit, judged_fit
from .fit_curves import (
    NONE,
    Trial,
    fits_start,
    prepared,
    refuse_unknown,
    refuse_weights,
    run_threads,
)
from .fits.objective import InitialTorque, nrmse, predicted, torque_errors
from .fits.parameters import FREE, Constraints, parameter_limits, parameters_of
from .fits.registry import FITS, Fitted, fit_model
from .judging.coverage import Coverage, loops_suffice, motion_coverage
from .judging.ensemble import (
    LEVEL,
    NARROW,
    Agreement,
    Candidate,
    Ensemble,
    agreement,
    drawn,
    ensemble,
)
from .judging.remarks import Remark
from .judging.uncertainty import Uncertainty
from .judging.verdict import DESCRIBES, NOT_BEYOND, predictions
from .methods import DEFAULT_MODEL, check_beginning

WORTH_IT = 0.95  # ratio to the error without memory: a smaller improvement may be chance
AS_GOOD = 1.1  # ratio to the best score up to which the model with fewest parameters is chosen
# Jiles-Atherton, and the same beside a polynomial, whose constant says nothing of the offset.
ITS_OWN = (DEFAULT_MODEL, "asymmetric")


class Choice(NamedTuple):
    """The chosen model, and the candidates.

    Attributes:
        chosen: The chosen candidate.
        candidates: All that were tried, the best prediction first.
        why: The reason, as a sentence.
        interrupted: Whether Ctrl-C ended it before all were tried.
        baselines: NRMSE of the same predictions by models without memory, by name.
    """

    chosen: Candidate
    candidates: tuple[Candidate, ...]
    why: str
    interrupted: bool
    baselines: dict[str, float]

    @property
    def unneeded(self) -> str:
        """Why no hysteresis model is needed, as a sentence; empty if one is."""
        name = min(self.baselines, key=lambda one: self.baselines[one], default="")
        own = self.chosen.prediction_nrmse
        if not name or own < WORTH_IT * self.baselines[name]:
            return ""
        return (
            f"{name} predicts the left-out data with NRMSE {self.baselines[name]:.2%}, and "
            f"{self.chosen.name}, the best choice among models with a memory, with {own:.2%}: the "
            "curves show no memory that needs one"
        )


def as_good(tried: Sequence[Candidate]) -> list[Candidate]:
    """Returns the candidates that predict nearly as well as the first, which predicts best."""
    most = AS_GOOD * tried[0].prediction_nrmse
    return [one for one in tried if one.prediction_nrmse <= most]


def choose(
    curves: Sequence[Curve],
    *,
    seed: int,
    workers: int,
    options: dict[str, dict[str, Any]],
    on_candidate: Callable[[Candidate], None] | None = None,
) -> Choice:
    """Chooses the model that predicts best, or a simpler one that predicts nearly as well.

    Each candidate is fitted to a part of the curves and predicts the rest, for each of the
    `questions` of `left_out`. The NRMSE of all these predictions is the score. Of the models within
    10 % of the best score the one with fewest parameters is chosen, and fitted to all curves.
    Everything a prediction uses, the torque at its beginning too, comes from the part that is
    fitted. Models without memory answer the same questions.

    Args:
        curves: First-order curves to fit, better 3 than 2, and 5 or more for the models of many
            weights; or one record of several cycles.
        seed: Seed of all random numbers.
        workers: Number of threads, which share the candidates.
        options: Options of the candidates' fits, by model.
        on_candidate: Function that gets each candidate as soon as it was tried.
    """
    asked = questions(curves)
    calls = [partial(_candidate, name, curves, asked, seed, options.get(name, {})) for name in FITS]
    found, interrupted = run_threads(calls, workers, on_candidate)
    order = list(FITS)
    tried = sorted(found, key=lambda one: (one.prediction_nrmse, order.index(one.name)))
    best = tried[0]
    if best.model is None:
        if interrupted:
            raise KeyboardInterrupt
        reasons = "; ".join(f"{candidate.name}: {candidate.reason}" for candidate in tried)
        raise InputError(f"no model could be fitted to these curves ({reasons})")
    chosen = min(as_good(tried), key=lambda candidate: candidate.parameters)
    why = _why(chosen, tried)
    baselines = predictions(asked, curves)
    if len(curves) == 1 and any(question.beyond for question in asked):
        why += (
            "; each cycle of the record is larger than those before, so that the predictions reach "
            "beyond the angles of the fits, where models differ more: a record that repeats its "
            "largest cycle tells more"
        )
    if interrupted:
        why += f"; interrupted after {len(tried)} of {len(FITS)} models"
    return Choice(chosen, tuple(tried), why, interrupted, baselines)


def _candidate(
    name: str,
    curves: Sequence[Curve],
    asked: Sequence[Question],
    seed: int,
    options: dict[str, Any],
) -> Candidate:
    def fitted(some: Sequence[Curve]) -> Fitted:
        return fit_model(name, some, np.random.default_rng(seed), **options)

    constraints: Constraints = options.get("constraints", FREE)
    try:
        constraints.check(name, options)
        errors = []
        for question in asked:
            found = fitted(question.known)
            torque = predicted(found.model, found.initial_torque, question.curve)
            errors.append(question.errors(torque))
        found = fitted(curves)
        on_fit = torque_errors(found.model, found.initial_torque, curves)
    except InputError as error:
        return Candidate(name=name, reason=str(error))
    known = sum(one.state != "free" for one in parameters_of(found.model, constraints))
    return Candidate(
        name=name,
        model=found.model,
        initial_torque=found.initial_torque,
        parameters=found.model.free_parameters - known,
        prediction_nrmse=nrmse(np.concatenate(errors), curves),
        prediction_errors=np.concatenate(errors),
        fit_nrmse=nrmse(on_fit, curves),
    )


def _why(chosen: Candidate, tried: Sequence[Candidate]) -> str:
    best = tried[0]
    score = f"with NRMSE {chosen.prediction_nrmse:.2%}"
    if chosen is not best:
        return (
            f"{chosen.name} predicts data left out of its fit {score}, within 10 % of the best "
            f"({best.name}, {best.prediction_nrmse:.2%}), and has fewer parameters "
            f"({chosen.parameters} instead of {best.parameters})"
        )
    text = f"{chosen.name} predicts data left out of its fit best, {score}"
    if len(tried) == 1 or tried[1].model is None:
        return f"{text}; no other model was fitted"
    return (
        f"{text} (next is {tried[1].name}, {tried[1].prediction_nrmse:.2%}), and no model within "
        f"10 % of that has fewer parameters than its {chosen.parameters}"
    )


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Result of `select`.

    Attributes:
        fit: Certified fit of the chosen model to all curves.
        why: The reason of the choice, as a sentence.
        candidates: All models that were tried, the best prediction first.
        ensemble: Candidates that predict left-out curves nearly as well as the best, of which
            `band` is made; None where all meet a pole.
        agreement: How far these differ on the intended motions; None without such motions.
    """

    fit: Fit
    why: str
    candidates: tuple[Candidate, ...]
    ensemble: Ensemble | None
    agreement: Agreement | None = None

    def band(self, curve: Curve, level: float = LEVEL) -> tuple[Array, Array]:
        """Returns the ends of a band of the torque along a curve [N·m], shape (samples,) each.

        The band of `Fit.uncertainty` is valid if the kind of model is right; this one also covers
        the differences between kinds of model that the curves allow, see `Ensemble.band`.

        Args:
            curve: Motion; its torque is used only where the fit began with the measured one.
            level: Share of the samples that the band is to contain, between 0 and 1.

        Raises:
            InputError: All models meet a pole, or see `Ensemble.band`.
        """
        if self.ensemble is None:
            raise InputError("every model meets its pole on the curves: there is no band")
        return self.ensemble.band(curve, level)

    def uncertainty(self, *, samples: int = 0, seed: int = 0) -> Uncertainty:
        """Returns the uncertainty of the chosen model, with samples of all kinds.

        Args:
            samples: Number of models to draw, of all kinds in the ensemble by their weight.
            seed: Seed of their noise.
        """
        if self.ensemble is None:
            return self.fit.uncertainty(samples=samples, seed=seed)
        found, fit = self.fit.uncertainty(seed=seed), self.fit
        members = drawn(
            self.ensemble, fit.curves, fit.initial_torque, samples, seed, fit.constraints
        )
        rivals = (name for one in members for name in one.offset_open if name not in ITS_OWN)
        return replace(
            found,
            samples=tuple(model for one in members for model in one.samples),
            left_open=tuple(dict.fromkeys(open for one in members for open in one.left_open)),
            offset_open=tuple(dict.fromkeys((*found.offset_open, *rivals))),
        )


def select(
    curves: Sequence[Curve],
    *,
    corrections: Corrections = NONE,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    initial_torque: InitialTorque | None = None,
    seed: int = 0,
    workers: int = -1,
    needed: Coverage | None = None,
    intended: Sequence[Motion] = (),
    on_candidate: Callable[[Candidate], None] | None = None,
    on_trial: Callable[[Trial], None] | None = None,
    **old: Any,
) -> Selection:
    """Selects the simplest model that predicts well the curves left out of its certified fit.

    Every model is fitted to all curves but one, or to a part of a long record, and predicts the
    rest, for each in turn. Ctrl-C keeps the finished models.

    Args:
        curves: The measurements; those with role "predict" are kept out and tested.
        corrections: What is taken off the curves, or fitted beside the models; tare and softening
            are those of Jiles-Atherton. A fitted tare that a model as good leaves open is not taken
            off: the models are fitted again without one, and the first remark of the fit says so.
        fixed: Parameters that keep a value, see `fit_curves`; models without one are not chosen.
        bounds: Lower and upper bound of parameters, likewise.
        initial_torque: The torque with which the curves begin, as in `fit_curves`: by default 0 for
            Jiles-Atherton where there are several curves; or "identified".
        seed: Seed of all random numbers.
        workers: The number of threads, which share the models; -1 uses all cores.
        needed: Coverage of the intended motions, see `fit_curves`; by default that of `intended`.
        intended: Intended motions, on which the kinds of model are compared: the verdict extends to
            loops that the curves do not have if a tested band is narrow there.
        on_candidate: Function that gets each model as soon as it was tried.
        on_trial: Function that gets the fit of the chosen model.
        **old: Names of version 0.2, which are refused with the new one.

    Raises:
        InputError: There is too little to leave out, no model can be fitted, or see `fit_curves`.
    """
    refuse_unknown(old)
    check_beginning(initial_torque)
    check_seed(seed)
    check_workers(workers)
    if sum(one.role == "fit" for one in curves) == 1:
        initial_torque = "identified"  # a record may begin anywhere, unlike first-order curves
    start: dict[str, Any] = {} if initial_torque is None else {"initial_torque": initial_torque}
    if needed is None and intended:
        needed = motion_coverage(intended)
    constraints = Constraints(fixed or {}, bounds or {})
    _refuse_unknown_parameters(constraints, corrections)
    ready = prepared(curves, DEFAULT_MODEL, corrections, start, seed, constraints)
    refuse_weights(ready.measured)
    beside = corrections.beside | {"constraints": constraints}
    ways = dict.fromkeys(FITS, beside) | {DEFAULT_MODEL: start | beside}
    choice = choose(
        ready.measured, seed=seed, workers=workers, options=ways, on_candidate=on_candidate
    )
    if corrections.tare == "fit":
        rival = _open_offset(choice, ready.measured, seed, ways)
        if rival and choice.interrupted:
            raise KeyboardInterrupt
        if rival:
            whole = select(
                curves,
                corrections=replace(corrections, tare=0.0),
                fixed=fixed,
                bounds=bounds,
                initial_torque=initial_torque,
                seed=seed,
                workers=workers,
                needed=needed,
                intended=intended,
                on_candidate=on_candidate,
                on_trial=on_trial,
            )
            remark = _not_taken_off(ready.tare, rival)
            return replace(whole, fit=replace(whole.fit, remarks=(remark, *whole.fit.remarks)))
    trial = _trial(choice.chosen)
    if on_trial is not None:
        on_trial(trial)
    fit = judged_fit(
        ready,
        corrections,
        choice.chosen.name,
        "auto",
        [trial],
        needed,
        constraints=constraints,
        fitted_start=fits_start(choice.chosen.name, initial_torque),
        interrupted=choice.interrupted,
        memoryless=choice.unneeded,
    )
    members = alike = None
    if fit.judgement is not None:
        members = ensemble(
            choice.candidates,
            ready.measured,
            fit.judgement.noise,
            seed=seed,
            options=ways,
            fitted_start=lambda name: fits_start(name, initial_torque),
        )
    if members is not None and intended:
        alike = agreement(members, intended, ready.measured.peak)
        fit = _weighed(fit, alike, needed)
    return Selection(
        fit=fit,
        why=choice.why,
        candidates=choice.candidates,
        ensemble=members,
        agreement=alike,
    )


def _refuse_unknown_parameters(constraints: Constraints, corrections: Corrections) -> None:
    """Refuses names that no model has; models without one of them are left out."""
    known = {
        name for kind in FITS for name in parameter_limits(kind, corrections.beside, "certified")
    }
    for name in constraints.names:
        if name.partition("[")[0] not in known:
            raise unknown_name("parameter", name, known)


def _open_offset(
    choice: Choice, curves: Curves, seed: int, options: Mapping[str, dict[str, Any]]
) -> str | None:
    """Returns a model as good as Jiles-Atherton that fits with any offset; None without one.

    Args:
        choice: Candidates, fitted to the curves less the offset that Jiles-Atherton finds.
        curves: These curves.
        seed: Seed of the fits.
        options: Options of the candidates' fits, by model.
    """
    for rival in as_good(choice.candidates):
        if rival.name in ITS_OWN:
            continue

        def error(some: Curves, name: str = rival.name) -> float:
            return fit_model(name, some, np.random.default_rng(seed), **options[name]).loss

        if is_open(curves, error):
            return rival.name
    return None


def _not_taken_off(tare: float, rival: str) -> Remark:
    """Returns the remark that an offset was not taken off, since a model fits with any."""
    return Remark(
        "open",
        "no offset of the torque sensor is taken off, because these curves do not determine it: "
        f"{tare:.3g} N·m by {DEFAULT_MODEL}, any by {rival}, which predicts them as well; zero "
        "the sensor, or give the tare as a number",
    )


def _weighed(fit: Fit, alike: Agreement | None, needed: Coverage | None) -> Fit:
    """Returns a fit whose verdict extends to intended loops if a tested band is narrow there."""
    if fit.verdict != NOT_BEYOND or alike is None or needed is None:
        return fit
    assert fit.judgement is not None and fit.coverage is not None  # there is a verdict
    narrow = alike.tested and alike.half_width <= NARROW * fit.curves.peak
    if not narrow or not loops_suffice(fit.coverage, needed):
        return fit
    remarks = tuple(one for one in fit.remarks if one.code != "coverage")
    return replace(fit, judgement=replace(fit.judgement, verdict=DESCRIBES), remarks=remarks)


def _trial(chosen: Candidate) -> Trial:
    assert chosen.model is not None  # a candidate without a fit is never chosen
    return Trial(
        index=0,
        model=chosen.model,
        initial_torque=chosen.initial_torque,
        nrmse=chosen.fit_nrmse,
        loss=chosen.fit_nrmse,
        evaluations=None,
    )
