"""The candidates of `select`, and the simplest of those that predict curves outside their fits."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..arrays import Array
from ..errors import InputError
from ..hysteresis.protocol import HysteresisModel
from ._threads import run_threads
from .baselines import predictions
from .curves import Curve
from .fits.registry import FITS, Fitted, fit_model
from .left_out import Question, questions
from .objective import InitialTorque
from .prediction import nrmse, predicted, torque_errors

WORTH_IT = 0.95  # ratio to the error without memory: a smaller improvement may be chance
AS_GOOD = 1.1  # ratio to the best score up to which the model with fewest parameters is chosen


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One model that `select` tried.

    Attributes:
        name: Name of the model.
        model: Model that is fitted to all curves; None where that failed.
        initial_torque: Torque with which the curves begin [N·m].
        parameters: Number of parameters that the fit chooses.
        prediction_nrmse: NRMSE over what was left out of the fit; infinite where it failed.
        prediction_errors: Errors of these predictions [N·m], of all left-out samples end to end,
            alike for all candidates; empty where it failed.
        fit_nrmse: NRMSE on the fitted curves; infinite where it failed.
        reason: Why it failed, as a sentence; empty if it did not.
    """

    name: str
    model: HysteresisModel | None = None
    initial_torque: InitialTorque = 0.0
    parameters: int = 0
    prediction_nrmse: float = float("inf")
    fit_nrmse: float = float("inf")
    reason: str = ""
    prediction_errors: Array = field(default_factory=lambda: np.empty(0), repr=False, compare=False)


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
    def good(self) -> list[Candidate]:
        """The candidates that predict nearly as well as the best."""
        return as_good(self.candidates)

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

    try:
        errors = []
        for question in asked:
            found = fitted(question.known)
            torque = predicted(found.model, found.initial_torque, question.curve)
            errors.append(question.errors(torque))
        found = fitted(curves)
        on_fit = torque_errors(found.model, found.initial_torque, curves)
    except InputError as error:
        return Candidate(name=name, reason=str(error))
    return Candidate(
        name=name,
        model=found.model,
        initial_torque=found.initial_torque,
        parameters=found.model.free_parameters,
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
