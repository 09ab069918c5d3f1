"""Verdict on whether a fitted model describes the curves, derived from printed numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.protocol import HysteresisModel
from ..baselines import baseline_errors
from ..curves import Curve, Curves
from ..objective import InitialTorque
from ..prediction import nrmse, torque_errors
from ..remarks import Remark
from ..thinning import thinned
from .causes import Cause, causes
from .misfit import LEAST_FREEDOM, Explained, explained, repeated_noise, smooth_columns
from .noise import Noise, independent
from .tangent import coordinates_of, tangent

DESCRIBES = "describes the curves"
NOT_BEYOND = "describes the curves, not beyond"
NOT = "does not describe the curves"
JUDGED = 5_000  # approximate samples of all curves together: more take long and add little
MATTERS = 1e-3  # share of the peak that a good load cell resolves: less gets no remark
UNLIKELY = 0.005  # probability of a misfit by noise alone, below which it is reported
HARDLY = 1e-3  # singular value over the largest one: models of many weights have many small ones
UNFINISHED = 1.05  # ratio to the least error, from which on a search has ended too early
TIMES_NOISE = 1.3  # ratio of residual to noise, from which on a misfit matters
HARDLY_BETTER = 0.9  # ratio to the error of a constant torque, from which on a model is useless
FAR = 6.0  # deviations from the neighbors, which normal noise reaches once in 500 million samples
FEWEST_OUTLIERS = 2  # a single one may be a reversal
WANDERS = 0.3  # correlation from sample to sample that may be noise or misfit


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """Verdict on a model by the residual of its fit.

    Attributes:
        verdict: "describes the curves", "describes the curves, not beyond" (they do not cover the
            intended motion, or contain no nested loops), or "does not describe the curves".
        times_noise: Root mean square of the residual over the noise; a lower limit where a part of
            a misfit counts as noise.
        misfit: The F test of the residual's smooth part.
        noise: Noise of the torque.
        causes: Faults of the measurement that the residual shows, the most certain first.
        baselines: NRMSE of models without memory on the same curves, by name.
        remarks: Reasons to doubt the model or the curves.
    """

    verdict: str
    times_noise: float
    misfit: Explained
    noise: Noise
    causes: tuple[Cause, ...]
    baselines: dict[str, float]
    remarks: tuple[Remark, ...]

    def to_dict(self) -> dict[str, object]:
        """Returns everything as plain values."""
        return {
            "verdict": self.verdict,
            "times_noise": self.times_noise,
            "noise": self.noise.deviation,
            "noise_correlation": self.noise.memory,
            "misfit": {
                "F": self.misfit.statistic,
                "columns": self.misfit.columns,
                "probability": self.misfit.probability,
                "threshold": UNLIKELY,
            },
            "causes": {
                one.name: {"size": one.size, "probability": one.explained.probability}
                for one in self.causes
            },
            "baselines": self.baselines,
        }


def judge(
    model: HysteresisModel,
    initial_torque: InitialTorque,
    curves: Sequence[Curve],
    *,
    fitted_start: bool,
    beyond: bool,
    searched: bool = False,
) -> Judgement | None:
    """Judges a fit by its residual; None where the model meets its pole on the curves.

    Args:
        model: Fitted model.
        initial_torque: Torque with which the curves begin [N·m], or "measured".
        curves: Fitted curves.
        fitted_start: Whether the fit chose that torque.
        beyond: Whether the curves do not cover the intended motion; without such a motion, whether
            they contain no nested loops.
        searched: Whether a swarm or the like searched for least squares, and may have ended early.

    Raises:
        InputError: There are no more samples than numbers that the model fits.
    """
    family = thinned(curves, JUDGED)
    residual = -torque_errors(model, initial_torque, family)
    if not np.isfinite(residual).all():
        return None
    slopes = tangent(coordinates_of(model, initial_torque, fitted_start=fitted_start), family)
    slopes = _reached(slopes)
    if residual.size <= slopes.shape[1] + LEAST_FREEDOM:
        raise InputError(
            f"the fitted curves have {residual.size} samples in all, and the model "
            f"{model.name!r} fits {slopes.shape[1]} numbers to them: give more samples, or choose "
            "a model with fewer numbers"
        )
    sizes = [curve.torque.size for curve in family]
    known, smooth = repeated_noise(family), smooth_columns(family)
    misfit = explained(residual, slopes, smooth, sizes, known)
    own = nrmse(residual, family)
    matters = own > MATTERS
    torque = np.concatenate([curve.torque for curve in family])
    found = _Findings(
        family=family,
        residual=residual,
        slopes=slopes,
        smooth=smooth,
        sizes=sizes,
        known=known,
        misfit=misfit,
        own=own,
        constant=float(np.std(torque)) / family.peak,
        surely=misfit.probability < UNLIKELY and matters,
        unfinished=_unfinished(residual, slopes) if searched else 1.0,
        causes=causes(model, initial_torque, family, residual, slopes, known) if matters else [],
        baselines=baseline_errors(family),
    )
    verdict = NOT if found.wrong else NOT_BEYOND if beyond else DESCRIBES
    return Judgement(
        verdict=verdict,
        times_noise=misfit.times_noise,
        misfit=misfit,
        noise=misfit.noise,
        causes=tuple(found.causes),
        baselines=found.baselines,
        remarks=tuple(_remarks(found)),
    )


class _Findings(NamedTuple):
    """What a residual says, from which verdict and remarks follow.

    Attributes:
        family: The curves that are judged.
        residual: Measured less fitted torque [N·m].
        slopes: Directions in which the parameters change the torque.
        smooth: Smooth functions that a misfit may have.
        sizes: Number of samples of each curve.
        known: Noise from repeated measurements; None without any.
        misfit: The part of the residual that is not noise.
        own: NRMSE of the fit.
        constant: NRMSE of a constant torque.
        surely: Whether the misfit is hardly due to chance, and large enough to matter.
        unfinished: Error over the least one nearby.
        causes: Named faults that would explain the residual, the best first.
        baselines: NRMSE of models without memory, by name.
    """

    family: Curves
    residual: Array
    slopes: Array
    smooth: Array
    sizes: list[int]
    known: Noise | None
    misfit: Explained
    own: float
    constant: float
    surely: bool
    unfinished: float
    causes: list[Cause]
    baselines: dict[str, float]

    @property
    def nothing(self) -> bool:
        """Whether the model explains next to nothing."""
        return self.own >= HARDLY_BETTER * self.constant

    @property
    def wrong(self) -> bool:
        """Whether the model does not describe the curves."""
        sure = self.surely or self.unfinished >= UNFINISHED
        matters = self.own > MATTERS and self.misfit.times_noise >= TIMES_NOISE and sure
        saved = (_saved(self.residual, self.slopes, one.column) for one in self.causes)
        return matters or self.nothing or max(saved, default=1.0) >= TIMES_NOISE


def _remarks(found: _Findings) -> Iterator[Remark]:
    """Yields the remarks on a fit, the most important first."""
    own, baselines = found.own, found.baselines
    if found.surely:
        yield from _misfit_remarks(found.misfit, found.known, found.family)
    if found.nothing:
        yield Remark(
            "nothing",
            f"the model explains next to nothing of the torque (NRMSE {own:.2%}, a constant torque "
            f"{found.constant:.2%}): check the columns, or measure larger motions",
        )
    yield from _outlier_remarks(found.residual, found.sizes)
    yield from _cause_remarks(found)
    if found.unfinished >= UNFINISHED and own > MATTERS:
        less = 1 - 1 / found.unfinished
        yield Remark(
            "search",
            f"the search ended before the least error, which is about {less:.0%} less: give it "
            "more trials or a larger budget, or use the certified method",
            ("method", "certified"),
        )
    memory = found.misfit.noise.memory
    if not found.surely and found.known is None and memory > WANDERS:
        yield Remark(
            "wandering",
            f"the residual wanders (correlation {memory:.2f} from sample to sample), "
            "which may be noise or misfit: measure every curve twice to tell which",
        )
    best = min(baselines, key=lambda name: baselines[name])
    if baselines[best] <= own:
        yield Remark(
            "memoryless",
            f"the curves are described as well by {best} (NRMSE {baselines[best]:.2%} against "
            f"{own:.2%}): they show no memory that needs this model",
        )


def _cause_remarks(found: _Findings) -> Iterator[Remark]:
    """Yields the first cause, and others until one explains the rest of the residual."""
    for i, cause in enumerate(found.causes):
        both = np.column_stack([found.slopes, cause.column])
        rest = explained(found.residual, both, found.smooth, found.sizes, found.known).probability
        if not found.surely or rest >= UNLIKELY or i == 0:
            remark = cause.remark
            if rest < UNLIKELY:
                remark = replace(remark, sentence=f"perhaps {remark.sentence}")
            yield remark
            if rest >= UNLIKELY:
                return


def _reached(slopes: Array) -> Array:
    """Returns the directions in which the parameters change the torque, without weak ones."""
    basis, singular, _ = np.linalg.svd(slopes, full_matrices=False)
    return basis[:, singular > HARDLY * singular[0]] if singular.size else basis


def _unfinished(residual: Array, slopes: Array) -> float:
    """Returns the error over the least one nearby, predicted by the derivatives of the model."""
    basis = independent(slopes)
    least = residual - basis @ (basis.T @ residual)
    return float(np.linalg.norm(residual) / max(np.linalg.norm(least), np.finfo(float).tiny))


def _saved(residual: Array, slopes: Array, column: Array) -> float:
    """Returns the residual over the one that remains if the column of a fault is fitted too."""
    basis = independent(np.column_stack([slopes, column]))
    rest = residual - basis @ (basis.T @ residual)
    return float(np.linalg.norm(residual) / max(np.linalg.norm(rest), np.finfo(float).tiny))


def _outlier_remarks(residual: Array, sizes: Sequence[int]) -> list[Remark]:
    """Returns a remark about single samples far from their neighbors, if there are any.

    The statistic is the residual less the mean of its two neighbors, which a smooth misfit leaves
    small, over its deviation by the median, which outliers leave as it is.
    """
    parts = np.split(residual, np.cumsum(sizes)[:-1])
    apart = np.concatenate([one[1:-1] - (one[:-2] + one[2:]) / 2 for one in parts])
    scale = 1.4826 * float(np.median(np.abs(apart)))
    if scale == 0:
        return []  # no noise, or torques so coarse that most samples repeat the one before
    size = np.pad(np.abs(apart), 1)
    peaks = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])  # outliers, not their neighbors
    far = np.abs(apart[peaks & (np.abs(apart) > FAR * scale)])
    if far.size < FEWEST_OUTLIERS:
        return []
    return [
        Remark(
            "outliers",
            f"{far.size} samples are up to {far.max():.2g} N·m off their neighbors, more than "
            f"{FAR:g} times the usual deviation: remove these outliers, or search with an "
            "objective that bears them, such as by sa-pso",
            ("objective", "robust"),
        )
    ]


def _misfit_remarks(misfit: Explained, known: Noise | None, curves: Curves) -> list[Remark]:
    origin = "of repeated curves" if known else "that is estimated beside it"
    share, seldom = misfit.noise.deviation / curves.peak, max(misfit.probability, 1e-9)
    return [
        Remark(
            "misfit",
            f"the residual is at least {misfit.times_noise:.2f} times the noise {origin} "
            f"({share:.2%} of the peak), and noise alone leaves so smooth a residual in at most "
            f"{seldom:.0e} of all fits (reported below {UNLIKELY:g}): check columns, order and "
            "beginning of the curves, or choose another model",
            ("method", "auto"),
        )
    ]
