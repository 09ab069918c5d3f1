"""Verdict on whether a fitted model describes the curves, derived from printed numbers."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.branches import Branches, spring, spring_with_friction, two_branches
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves
from ..data.parts import Question
from ..fits.objective import InitialTorque, nrmse, torque_errors
from ..fits.parameters import FREE, Constraints
from ..fits.tangent import beside, coordinates_of, independent, tangent
from .causes import Cause, Residual, causes
from .misfit import LEAST_FREEDOM, Explained, explained, outliers, repeated_noise, smooth_columns
from .noise import Noise, smoother_noise, uneven_noise
from .sentences import DESCRIBES, NOT, NOT_BEYOND, UNKNOWN, Remark, sentence

BASELINES: dict[str, Callable[[Array, Array], Branches]] = {
    "a spring": spring,
    "a spring with friction": spring_with_friction,
    "two branches without memory": two_branches,
}
MATTERS = 1e-3  # NRMSE that a good load cell resolves: a smaller one gets no remark
UNLIKELY = 0.005  # probability of a misfit by noise alone, below which the misfit is reported
HARDLY = 1e-3  # least singular value over the largest: models of many weights have many small ones
WITHOUT_REPEATS = 0.05  # NRMSE above which only repeated curves show that the rest is noise
UNFINISHED = 1.05  # ratio to the least error, from which on a search has ended too early
TIMES_NOISE = 1.3  # ratio of the residual to the bound of the noise, from which on a misfit matters
HARDLY_BETTER = 0.9  # ratio to the error of a constant torque, from which on a model is useless


def baseline_errors(curves: Sequence[Curve]) -> dict[str, float]:
    """Returns the NRMSE of models without memory on the curves that they are fitted to."""
    whole = [Question(list(curves), curve, slice(None)) for curve in curves]
    return predictions(whole, curves)


def predictions(asked: Sequence[Question], curves: Sequence[Curve]) -> dict[str, float]:
    """Returns the NRMSE with which models without memory predict data left out of their fit.

    The largest torque of all curves divides the errors.
    """
    found = {}
    for name, fit in BASELINES.items():
        errors = []
        for question in asked:
            angle = np.concatenate([curve.angle for curve in question.known])
            torque = np.concatenate([curve.torque for curve in question.known])
            if fit is two_branches and not 1 <= np.sum(np.diff(angle) < 0) < angle.size - 1:
                break  # motions of one direction have no second branch
            model = fit(angle, torque)
            errors.append(question.errors(model.response(question.curve.angle)))
        else:
            found[name] = nrmse(np.concatenate(errors), curves)
    return found


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """Verdict on a model by the residual of its fit."""

    verdict: str = ""  # one of the four phrases of `judging.sentences`
    times_noise: float  # root mean square of the residual over the bound of the noise
    misfit: Explained  # F test of the residual's smooth part
    # Deviation of the noise [N·m]: of repeated curves; without them at most that of the residual of
    # a smooth curve through each branch.
    noise_bound: float
    is_repeated: bool  # whether repeated curves show the noise
    causes: tuple[Cause, ...]  # one or two faults that explain the residual down to the noise
    explained: float  # the residual over the residual with the causes fitted too
    nrmse: float
    constant: float  # NRMSE of a constant torque
    unfinished: float  # error over the least error nearby; 1 for fits that end at the least one
    baselines: dict[str, float]  # NRMSE of models without memory on the same curves, by name
    remarks: tuple[Remark, ...] = ()  # reasons to doubt the model or the curves

    @property
    def noise(self) -> Noise:
        """Noise of the torque, beside the parts that the F test takes as misfit."""
        return self.misfit.noise

    @property
    def is_misfit(self) -> bool:
        """Whether the misfit is hardly due to chance, and large enough to matter."""
        return self.misfit.probability < UNLIKELY and self.nrmse > MATTERS

    @property
    def explains_nothing(self) -> bool:
        """Whether the model explains next to nothing."""
        return self.nrmse >= HARDLY_BETTER * self.constant

    @property
    def is_wrong(self) -> bool:
        """Whether the model does not describe the curves."""
        sure = (
            self.is_misfit or self.unfinished >= UNFINISHED or self.explained >= TIMES_NOISE
        ) and self.times_noise >= TIMES_NOISE
        return self.explains_nothing or (self.nrmse > MATTERS and sure)

    @property
    def doubts(self) -> list[str]:
        """Reasons why only repeated curves can show whether the model describes the curves."""
        found = []
        if self.nrmse > MATTERS and self.times_noise >= TIMES_NOISE:
            found.append(sentence("doubt residual", **self.numbers))
        if self.is_misfit:
            found.append(sentence("doubt smooth", **self.numbers))
        if self.nrmse > WITHOUT_REPEATS and not self.is_repeated:
            found.append(sentence("doubt error", **self.numbers))
        return found

    @property
    def numbers(self) -> dict[str, Any]:
        """Numbers in the sentences of remarks."""
        return {
            "times": self.times_noise,
            "memory": self.noise.memory,
            "probability": max(self.misfit.probability, 1e-9),
            "threshold": UNLIKELY,
            "nrmse": self.nrmse,
            "constant": self.constant,
            "less": 1 - 1 / self.unfinished,
        }

    def to_dict(self) -> dict[str, object]:
        """Returns everything as plain values."""
        return {
            "verdict": self.verdict,
            "times_noise": self.times_noise,
            "noise": self.noise.deviation,
            "noise_share": self.noise.share,
            "noise_bound": self.noise_bound,
            "noise_correlation": self.noise.memory,
            "misfit": {
                "F": self.misfit.statistic,
                "columns": self.misfit.columns,
                "probability": self.misfit.probability,
                "threshold": UNLIKELY,
            },
            "causes": {
                x.name: {"curve": x.curve, "size": x.size, "probability": x.explained.probability}
                for x in self.causes
            },
            "baselines": self.baselines,
        }


def judge(
    model: HysteresisModel,
    initial_torque: InitialTorque,
    curves: Curves,
    *,
    fitted_start: bool,
    constraints: Constraints = FREE,
    beyond: bool,
    searched: bool = False,
) -> Judgement | None:
    """Judges a fit by its residual; None if the model meets its pole on the curves.

    The curves are thinned to about `JUDGED` samples. `fitted_start` is whether the fit chose the
    torque at their beginning; `beyond`, whether they do not cover the intended motion, or, without
    such a motion, have no nested loops; `searched`, whether a swarm or another optimizer searched
    for least squares, and may have ended early.
    """
    whole = -torque_errors(model, initial_torque, curves)
    if not np.isfinite(whole).all():
        return None
    coordinates = coordinates_of(
        model, initial_torque, fitted_start=fitted_start, constraints=constraints
    )
    reached = _reached(tangent(coordinates, curves))
    if whole.size <= reached.shape[1] + LEAST_FREEDOM:
        raise InputError(
            f"the fitted curves have {whole.size} samples in all, and the model "
            f"{model.name!r} fits {reached.shape[1]} numbers to them: give more samples, or choose "
            "a model with fewer numbers"
        )
    sizes = [curve.torque.size for curve in curves]
    measured = np.concatenate([curve.torque for curve in curves])
    uneven = uneven_noise(whole, measured - whole, sizes)
    scale = uneven.at(measured - whole)
    known, smooth = repeated_noise(curves, uneven), smooth_columns(curves) / scale[:, None]
    rest = Residual(
        coordinates, curves, whole / scale, reached / scale[:, None], smooth, scale, known
    )
    misfit = explained(rest.values, rest.slopes, smooth, sizes, known, uneven)
    bound = misfit.noise.deviation if known else min(misfit.noise.deviation, smoother_noise(curves))
    own, squares = nrmse(whole, curves), float(rest.values @ rest.values)
    found = tuple(causes(rest)) if own > MATTERS else ()
    left = math.sqrt(squares / max(whole.size - reached.shape[1], 1))
    nearby, tiny = np.linalg.norm(beside(independent(reached), whole)), np.finfo(float).tiny
    judged = Judgement(
        times_noise=left / max(bound, tiny),
        misfit=misfit,
        noise_bound=bound,
        is_repeated=known is not None,
        causes=found,
        explained=math.sqrt(squares / whole.size) / min((x.left for x in found), default=np.inf),
        nrmse=own,
        constant=float(np.std(measured)) / curves.peak,
        unfinished=float(np.linalg.norm(whole) / max(nearby, tiny)) if searched else 1.0,
        baselines=baseline_errors(curves),
    )
    verdict = NOT_BEYOND if beyond else DESCRIBES
    if judged.is_wrong or judged.doubts:
        verdict = NOT if judged.is_wrong else UNKNOWN
    return replace(judged, verdict=verdict, remarks=tuple(_remarks(judged, rest)))


def _remarks(judged: Judgement, rest: Residual) -> Iterator[Remark]:
    """Yields the remarks on a fit, the most important first."""
    values = judged.numbers
    if judged.is_wrong and judged.is_misfit:
        origin = sentence("noise repeated" if judged.is_repeated else "noise smooth")
        share = judged.noise_bound / rest.curves.peak
        yield Remark("misfit", values | {"origin": origin, "share": share})
    if judged.explains_nothing:
        yield Remark("nothing", values)
    yield from outliers(rest.values, rest.curves, rest.scale, is_misfit=judged.is_misfit)
    yield from (cause.remark for cause in judged.causes)
    if judged.unfinished >= UNFINISHED and judged.nrmse > MATTERS:
        yield Remark("search", values)
    if judged.doubts and not judged.is_wrong:
        yield Remark("wandering", {"doubts": "; ".join(judged.doubts)})
    best = min(judged.baselines, key=lambda name: judged.baselines[name])
    if judged.baselines[best] <= judged.nrmse:
        yield Remark("memoryless", values | {"baseline": best, "least": judged.baselines[best]})


def _reached(slopes: Array) -> Array:
    """Returns the directions in which the parameters change the torque, without weak ones."""
    basis, singular, _ = np.linalg.svd(slopes, full_matrices=False)
    return basis[:, singular > HARDLY * singular[0]] if singular.size else basis
