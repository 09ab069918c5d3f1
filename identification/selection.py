"""`select`: the kind of model that predicts best, and a band over all nearly as good kinds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..arrays import Array
from ..checks import check_seed
from ..checks import workers as check_workers
from ..errors import InputError, unknown_name
from .corrections.corrections import Corrections
from .corrections.tare import is_open
from .data.curves import Curve, Curves
from .data.files import Motion
from .data.parts import Question, questions
from .fit import Fit, judged_fit
from .fit_curves import NONE, Trial, fits_start, prepared, refuse_weights, run_threads
from .fits.objective import InitialTorque, nrmse, predicted, torque_errors
from .fits.parameters import FREE, Constraints, parameter_limits, parameters_of
from .fits.registry import FITS, Fitted, fit_model
from .judging.coverage import Coverage, motion_coverage
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
from .judging.judgement import predictions
from .judging.sentences import DESCRIBES, NOT_BEYOND, Remark, sentence
from .judging.uncertainty import Uncertainty
from .methods import DEFAULT_MODEL, check_beginning

WORTH_IT = 0.95  # ratio to the error without memory: a smaller improvement may be chance
AS_GOOD = 1.1  # ratio to the best score up to which the model with fewest parameters is chosen
# No rivals: Jiles-Atherton, and the same beside a polynomial, whose constant takes any offset.
ITS_OWN = (DEFAULT_MODEL, "asymmetric")


def as_good(tried: Sequence[Candidate]) -> list[Candidate]:
    """Returns the candidates that predict nearly as well as the first, which predicts best."""
    most = AS_GOOD * tried[0].prediction_nrmse
    return [one for one in tried if one.prediction_nrmse <= most]


def _candidate(
    name: str, curves: Curves, asked: Sequence[Question], seed: int, options: dict[str, Any]
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
        return Candidate(name=name, model=None, reason=str(error))
    known = sum(one.state != "free" for one in parameters_of(found.model, constraints))
    return Candidate(
        name=name,
        model=found.model,
        initial_torque=found.initial_torque,
        fitted_start=fits_start(name, options.get("initial_torque")),
        parameters=found.model.free_parameters - known,
        prediction_nrmse=nrmse(np.concatenate(errors), curves),
        prediction_errors=np.concatenate(errors),
        fit_nrmse=nrmse(on_fit, curves),
    )


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Result of `select`.

    Attributes:
        fit: Certified fit of the chosen model to all curves.
        candidates: All models that were tried, the best prediction first.
        ensemble: Candidates that predict left-out curves nearly as well as the best, from which
            `band` follows; None if all meet a pole.
        agreement: How far these differ on the intended motions; None without such motions.
        is_beyond: Whether predictions reach beyond the angles of the fits, as for a record whose
            every cycle is larger than the cycles before.
    """

    fit: Fit
    candidates: tuple[Candidate, ...]
    ensemble: Ensemble | None
    agreement: Agreement | None = None
    is_beyond: bool = False

    @property
    def why(self) -> str:
        """The reason of the choice, as a sentence."""
        best, *others = self.candidates
        chosen = next(one for one in self.candidates if one.name == self.fit.model_name)
        values: dict[str, Any] = {"name": chosen.name, "nrmse": chosen.prediction_nrmse}
        values |= {"parameters": chosen.parameters, "tried": len(self.candidates)}
        kind = "chosen alone"
        if chosen is not best:
            kind = "chosen simpler"
            values |= {"best": best.name, "least": best.prediction_nrmse, "others": best.parameters}
        elif others and others[0].model is not None:
            kind = "chosen best"
            values |= {"next": others[0].name, "second": others[0].prediction_nrmse}
        kinds = [kind, *["chosen beyond"] * self.is_beyond]
        kinds += ["chosen interrupted"] * self.fit.interrupted
        return "; ".join(sentence(one, **values, models=len(FITS)) for one in kinds)

    def band(self, curve: Curve, level: float = LEVEL) -> tuple[Array, Array]:
        """Returns the ends of a band of the torque along a curve [N·m], shape (samples,) each.

        The band of `Fit.uncertainty` is valid if the kind of model is right; this band also covers
        the differences between kinds of model that the curves allow, see `Ensemble.band`.

        Args:
            curve: Motion; its torque is used only where the fit began with the measured one.
            level: Share of the samples that the band is to contain, between 0 and 1.
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
            self.ensemble, fit.fitted_curves, fit.initial_torque, samples, seed, fit.constraints
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
) -> Selection:
    """Selects the simplest model that predicts curves well which were left out of its fit.

    Every kind of model is fitted to all curves but one, which the fit predicts, for each curve in
    turn; of a single record, to a first part. Ctrl-C keeps the finished models.

    Args:
        curves: The measurements; those with role "predict" are kept out and tested.
        corrections: Corrections of the curves, and terms that are fitted beside the models; tare
            and softening are those of Jiles-Atherton. If an equally good model fits with any tare,
            the models are fitted again without a tare, and the first remark of the fit says so.
        fixed: Parameters that keep a value, see `fit_curves`; models without them are not chosen.
        bounds: Lower and upper bound of parameters, see `fit_curves`.
        initial_torque: The torque with which the curves begin, as in `fit_curves`: by default 0 for
            Jiles-Atherton where there are several curves; or "identified".
        seed: Seed of all random numbers.
        workers: The number of threads, which share the models; -1 uses all cores.
        needed: Coverage of the intended motions, see `fit_curves`; by default of `intended`.
        intended: Intended motions, on which the kinds of model are compared: if a tested band is
            narrow there, the verdict extends to loops that the curves do not have.
        on_candidate: Function that gets every finished `Candidate`, in any order.
    """
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
    beside = corrections.beside | {"constraints": constraints}
    ways = dict.fromkeys(FITS, beside) | {DEFAULT_MODEL: start | beside}
    undetermined: list[Remark] = []
    while True:
        ready = prepared(curves, DEFAULT_MODEL, corrections, start, seed, constraints)
        measured = ready.measured
        refuse_weights(measured)
        asked = questions(measured)
        calls = [partial(_candidate, name, measured, asked, seed, ways[name]) for name in FITS]
        tried, interrupted = run_threads(calls, workers, on_candidate)
        order = list(FITS)
        tried.sort(key=lambda one: (one.prediction_nrmse, order.index(one.name)))
        if tried[0].model is None:
            if interrupted:
                raise KeyboardInterrupt
            reasons = "; ".join(f"{candidate.name}: {candidate.reason}" for candidate in tried)
            raise InputError(f"no model could be fitted to these curves ({reasons})")
        rival = _open_offset(tried, measured, seed, ways) if corrections.tare == "fit" else None
        if rival is None:
            break
        if interrupted:
            raise KeyboardInterrupt
        values = {"tare": ready.tare, "model": DEFAULT_MODEL, "rival": rival}
        undetermined = [Remark("open", values)]
        corrections = replace(corrections, tare=0.0)
    chosen = min(as_good(tried), key=lambda candidate: candidate.parameters)
    assert chosen.model is not None  # a candidate without a fit is never chosen
    trial = Trial(
        index=0,
        model=chosen.model,
        initial_torque=chosen.initial_torque,
        nrmse=chosen.fit_nrmse,
        loss=chosen.fit_nrmse,
        evaluations=None,
    )
    fit = judged_fit(
        ready,
        corrections,
        chosen.name,
        "auto",
        [trial],
        needed,
        constraints=constraints,
        fitted_start=chosen.fitted_start,
        interrupted=interrupted,
        memoryless=_memoryless(chosen, predictions(asked, measured)),
    )
    members = alike = None
    if fit.judgement is not None:
        members = ensemble(tried, measured, fit.judgement.noise, seed=seed, options=ways)
    if members is not None and intended:
        alike = agreement(members, intended, measured.peak)
        fit = _weighed(fit, alike)
    return Selection(
        fit=replace(fit, remarks=(*undetermined, *fit.remarks)),
        candidates=tuple(tried),
        ensemble=members,
        agreement=alike,
        is_beyond=len(measured) == 1 and any(question.beyond for question in asked),
    )


def _memoryless(chosen: Candidate, baselines: Mapping[str, float]) -> Remark | None:
    """Returns a remark if a model without memory predicts about as well."""
    name = min(baselines, key=lambda one: baselines[one], default="")
    own = chosen.prediction_nrmse
    if not name or own < WORTH_IT * baselines[name]:
        return None
    values = {"baseline": name, "least": baselines[name], "model": chosen.name, "nrmse": own}
    return Remark("memoryless prediction", values)


def _refuse_unknown_parameters(constraints: Constraints, corrections: Corrections) -> None:
    """Refuses names of parameters that no kind of model has."""
    known = {
        name for kind in FITS for name in parameter_limits(kind, corrections.beside, "certified")
    }
    for name in constraints.names:
        if name.partition("[")[0] not in known:
            raise unknown_name("parameter", name, known)


def _open_offset(
    tried: Sequence[Candidate], curves: Curves, seed: int, options: Mapping[str, dict[str, Any]]
) -> str | None:
    """Returns the name of an equally good model that fits with any offset; None without one.

    The curves are those without the offset that Jiles-Atherton finds.
    """
    for rival in as_good(tried):
        if rival.name in ITS_OWN:
            continue

        def error(some: Curves, name: str = rival.name) -> float:
            return fit_model(name, some, np.random.default_rng(seed), **options[name]).loss

        if is_open(curves, error):
            return rival.name
    return None


def _weighed(fit: Fit, alike: Agreement | None) -> Fit:
    """Returns a fit whose verdict extends to intended loops if a tested band is narrow there."""
    if fit.verdict != NOT_BEYOND or fit.judgement is None or alike is None:
        return fit
    narrow = alike.tested and alike.half_width <= NARROW * fit.curves.peak
    loops = ("coverage nesting", "coverage branches")  # a band says nothing outside the range
    if not narrow or any(one.kind not in loops for one in fit.shortfalls):
        return fit
    remarks = tuple(one for one in fit.remarks if one.code != "coverage")
    return replace(fit, judgement=replace(fit.judgement, verdict=DESCRIBES), remarks=remarks)
