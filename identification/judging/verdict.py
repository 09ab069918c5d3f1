"""Verdict on whether a fitted model describes the curves, derived from printed numbers."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.branches import Branches, spring, spring_with_friction, two_branches
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve
from ..data.parts import Question, thinned
from ..fits.objective import InitialTorque, nrmse, torque_errors
from ..fits.parameters import FREE, Constraints
from ..fits.tangent import beside, coordinates_of, independent, tangent
from .causes import Cause, Residual, causes
from .misfit import LEAST_FREEDOM, Explained, explained, outliers, repeated_noise, smooth_columns
from .noise import Noise, smoother_noise, uneven_noise
from .remarks import Remark

BASELINES: dict[str, Callable[[Array, Array], Branches]] = {
    "a spring": spring,
    "a spring with friction": spring_with_friction,
    "two branches without memory": two_branches,
}
DESCRIBES = "describes the curves"
NOT_BEYOND = "describes the curves, not beyond"
UNKNOWN = "cannot be judged by these curves: measure every curve twice"
NOT = "does not describe the curves"
JUDGED = 5_000  # approximate samples of all curves together: more take long and add little
MATTERS = 1e-3  # share of the peak that a good load cell resolves: less gets no remark
UNLIKELY = 0.005  # probability of a misfit by noise alone, below which it is reported
HARDLY = 1e-3  # singular value over the largest one: models of many weights have many small ones
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

    Args:
        asked: Parts that are left out, each with the curves that are fitted instead.
        curves: All curves, whose largest torque divides the errors.
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
    """Verdict on a model by the residual of its fit.

    Attributes:
        verdict: "describes the curves", "describes the curves, not beyond" (they do not cover the
            intended motion, or contain no nested loops), "cannot be judged by these curves: ..."
            (what is left is noise that wanders, or a misfit), or "does not describe the curves".
        times_noise: Root mean square of the residual over the bound of the noise.
        misfit: The F test of the residual's smooth part.
        noise_bound: Deviation of that noise, of repeated curves if there are any, and at most that
            of what a smooth curve through each branch leaves [N·m].
        causes: One or two faults of the measurement that explain the residual down to the noise.
        baselines: NRMSE of models without memory on the same curves, by name.
        remarks: Reasons to doubt the model or the curves.
    """

    verdict: str
    times_noise: float
    misfit: Explained
    noise_bound: float
    causes: tuple[Cause, ...]
    baselines: dict[str, float]
    remarks: tuple[Remark, ...]

    @property
    def noise(self) -> Noise:
        """Noise of the torque, beside the parts that the F test takes as misfit."""
        return self.misfit.noise

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
            "causes": {one.name: one.to_dict() for one in self.causes},
            "baselines": self.baselines,
        }


def judge(
    model: HysteresisModel,
    initial_torque: InitialTorque,
    curves: Sequence[Curve],
    *,
    fitted_start: bool,
    constraints: Constraints = FREE,
    beyond: bool,
    searched: bool = False,
) -> Judgement | None:
    """Judges a fit by its residual; None where the model meets its pole on the curves.

    Args:
        model: Fitted model.
        initial_torque: Torque with which the curves begin [N·m], or "measured".
        curves: Fitted curves.
        fitted_start: Whether the fit chose that torque.
        constraints: Parameters that the user fixed or bounded.
        beyond: Whether the curves do not cover the intended motion; without such a motion, whether
            they contain no nested loops.
        searched: Whether a swarm or the like searched for least squares, and may have ended early.
    """
    family = thinned(curves, JUDGED)
    whole = -torque_errors(model, initial_torque, family)
    if not np.isfinite(whole).all():
        return None
    coordinates = coordinates_of(
        model, initial_torque, fitted_start=fitted_start, constraints=constraints
    )
    reached = _reached(tangent(coordinates, family))
    if whole.size <= reached.shape[1] + LEAST_FREEDOM:
        raise InputError(
            f"the fitted curves have {whole.size} samples in all, and the model "
            f"{model.name!r} fits {reached.shape[1]} numbers to them: give more samples, or choose "
            "a model with fewer numbers"
        )
    sizes = [curve.torque.size for curve in family]
    torque = np.concatenate([curve.torque for curve in family]) - whole
    uneven = uneven_noise(whole, torque, sizes)
    scale = uneven.at(torque)
    known, smooth = repeated_noise(family, uneven), smooth_columns(family) / scale[:, None]
    rest = Residual(
        coordinates, family, whole / scale, reached / scale[:, None], smooth, scale, known
    )
    misfit = explained(rest.values, rest.slopes, smooth, sizes, known, uneven)
    bound = misfit.noise.deviation if known else min(misfit.noise.deviation, smoother_noise(family))
    own = nrmse(whole, family)
    left = math.sqrt(float(rest.values @ rest.values) / max(whole.size - reached.shape[1], 1))
    found = _Findings(
        rest=rest,
        misfit=misfit,
        bound=bound,
        times_noise=left / max(bound, np.finfo(float).tiny),
        own=own,
        constant=float(np.std(np.concatenate([curve.torque for curve in family]))) / family.peak,
        unfinished=_unfinished(whole, reached) if searched else 1.0,
        causes=tuple(causes(rest)) if own > MATTERS else (),
        baselines=baseline_errors(family),
    )
    describes = NOT_BEYOND if beyond else DESCRIBES
    return Judgement(
        verdict=NOT if found.wrong else UNKNOWN if found.doubts else describes,
        times_noise=found.times_noise,
        misfit=misfit,
        noise_bound=bound,
        causes=found.causes,
        baselines=found.baselines,
        remarks=tuple(_remarks(found)),
    )


class _Findings(NamedTuple):
    """What a residual says, from which verdict and remarks follow.

    Attributes:
        rest: The residual.
        misfit: The part of the residual that is not noise.
        bound: Deviation that the noise has at most [N·m].
        times_noise: The residual over that bound.
        own: NRMSE of the fit.
        constant: NRMSE of a constant torque.
        unfinished: Error over the least one nearby.
        causes: Faults that explain the residual down to the noise.
        baselines: NRMSE of models without memory, by name.
    """

    rest: Residual
    misfit: Explained
    bound: float
    times_noise: float
    own: float
    constant: float
    unfinished: float
    causes: tuple[Cause, ...]
    baselines: dict[str, float]

    @property
    def surely(self) -> bool:
        """Whether the misfit is hardly due to chance, and large enough to matter."""
        return self.misfit.probability < UNLIKELY and self.own > MATTERS

    @property
    def nothing(self) -> bool:
        """Whether the model explains next to nothing."""
        return self.own >= HARDLY_BETTER * self.constant

    @property
    def wrong(self) -> bool:
        """Whether the model does not describe the curves."""
        if self.nothing:
            return True
        sure = self.surely or self.unfinished >= UNFINISHED or self.explained >= TIMES_NOISE
        return self.own > MATTERS and self.times_noise >= TIMES_NOISE and sure

    @property
    def doubts(self) -> list[str]:
        """Why only repeated curves can tell whether the model describes the curves."""
        if self.own <= MATTERS:
            return []
        noise = self.misfit.noise
        found = []
        if self.times_noise >= TIMES_NOISE:
            found.append(
                f"the residual is {self.times_noise:.2f} times what a smooth curve through each "
                f"branch leaves, and wanders (correlation {noise.memory:.2f} from sample to sample)"
            )
        if self.surely:
            found.append(
                f"the residual has a smooth part, which noise alone leaves in at most "
                f"{_seldom(self.misfit):.0e} of all fits (reported below {UNLIKELY:g})"
            )
        if self.rest.known is None and self.own > WITHOUT_REPEATS:
            found.append(f"the error is {self.own:.1%} of the peak")
        return found

    @property
    def explained(self) -> float:
        """The residual over what is left if the causes are fitted too."""
        left = min((one.left for one in self.causes), default=np.inf)
        return float(np.sqrt(np.mean(self.rest.values**2))) / left


def _seldom(misfit: Explained) -> float:
    return max(misfit.probability, 1e-9)


def _remarks(found: _Findings) -> Iterator[Remark]:
    """Yields the remarks on a fit, the most important first."""
    own, baselines = found.own, found.baselines
    if found.wrong and found.surely:
        yield _misfit_remark(found)
    if found.nothing:
        yield Remark(
            "nothing",
            f"the model explains next to nothing of the torque (NRMSE {own:.2%}, a constant torque "
            f"{found.constant:.2%}): check the columns, or measure larger motions",
        )
    rest = found.rest
    yield from outliers(rest.values, rest.curves, rest.scale, is_misfit=found.surely)
    yield from (cause.remark for cause in found.causes)
    if found.unfinished >= UNFINISHED and own > MATTERS:
        less = 1 - 1 / found.unfinished
        yield Remark(
            "search",
            f"the search ended before the least error, which is about {less:.0%} less: give it "
            "more trials or a larger budget, or use the certified method",
            ("method", "certified"),
        )
    if found.doubts and not found.wrong:
        yield Remark(
            "wandering",
            f"{'; '.join(found.doubts)}: that may be noise or misfit; measure every curve twice "
            "to tell which: repeat the motion with as many samples, and fit both records together",
        )
    best = min(baselines, key=lambda name: baselines[name])
    if baselines[best] <= own:
        yield Remark(
            "memoryless",
            f"the curves are described as well by {best} (NRMSE {baselines[best]:.2%} against "
            f"{own:.2%}): they show no memory that needs this model",
        )


def _reached(slopes: Array) -> Array:
    """Returns the directions in which the parameters change the torque, without weak ones."""
    basis, singular, _ = np.linalg.svd(slopes, full_matrices=False)
    return basis[:, singular > HARDLY * singular[0]] if singular.size else basis


def _unfinished(residual: Array, slopes: Array) -> float:
    """Returns the error over the least one nearby, predicted by the derivatives of the model."""
    basis = independent(slopes)
    least = beside(basis, residual)
    return float(np.linalg.norm(residual) / max(np.linalg.norm(least), np.finfo(float).tiny))


def _misfit_remark(found: _Findings) -> Remark:
    smooth = "that smooth curves through the branches leave"
    origin = "of repeated curves" if found.rest.known else smooth
    share = found.bound / found.rest.curves.peak
    return Remark(
        "misfit",
        f"the residual is {found.times_noise:.2f} times the noise {origin} ({share:.2%} of the "
        f"peak), and noise alone leaves so smooth a residual in at most "
        f"{_seldom(found.misfit):.0e} of all fits (reported below {UNLIKELY:g}): check columns, "
        "order and beginning of the curves, or choose another model",
        ("method", "auto"),
    )
