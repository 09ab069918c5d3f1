"""Whether a fitted model describes the curves, in words that follow from printed numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import Array
from ...errors import InputError
from ...hysteresis.protocol import HysteresisModel
from ..baselines import baseline_errors
from ..curves import Curve, Curves
from ..objective import InitialTorque
from ..prediction import nrmse, torque_errors
from ..thinning import thinned
from .causes import Cause, causes
from .misfit import LEAST_FREEDOM, Explained, explained, repeated_noise, smooth_columns
from .noise import Noise, independent
from .tangent import coordinates_of, tangent

DESCRIBES = "describes the curves"
NOT_BEYOND = "describes the curves, not beyond"
NOT = "does not describe the curves"
JUDGED = 5_000  # samples of all curves together, about: more take long and tell little more
MATTERS = 1e-3  # of the peak: what a good load cell resolves; less is no misfit worth a word
UNLIKELY = 0.005  # probability of a misfit by noise alone below which it is told
HARDLY = 1e-3  # of the strongest direction: models of many weights have many weak ones
UNFINISHED = 1.05  # times the least error, beyond which a search has ended too early
TIMES_NOISE = 1.3  # beyond it a misfit is one that matters
HARDLY_BETTER = 0.9  # times the error of a constant torque: a model that leaves so much is none
FAR = 6.0  # deviations from the neighbors, which normal noise reaches once in 500 million samples
FEWEST_OUTLIERS = 2  # one may be a reversal
WANDERS = 0.3  # correlation from sample to sample that may be noise or misfit


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """What the residual of a fit says about its model.

    Attributes:
        verdict: "describes the curves", "describes the curves, not beyond" (the intended motion has
            something in it that they do not tell, or they hold no loops inside loops), or "does not
            describe the curves".
        times_noise: Root mean square of the residual over the noise; at least that where a misfit
            hides in the noise.
        misfit: The F test of the residual's smooth part.
        noise: Noise of the torque.
        causes: Faults of the measurement that the residual shows, the surest first.
        baselines: NRMSE of models without memory on the same curves, by name.
        remarks: All of it in sentences, for whoever should doubt.
    """

    verdict: str
    times_noise: float
    misfit: Explained
    noise: Noise
    causes: tuple[Cause, ...]
    baselines: dict[str, float]
    remarks: tuple[str, ...]

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
        beyond: Whether the intended motion has something in it that the curves do not tell; without
            such a motion, whether the curves hold no loops inside loops.
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
    surely = misfit.probability < UNLIKELY and own > MATTERS
    found = causes(model, initial_torque, family, residual, slopes, known) if own > MATTERS else []
    times = misfit.times_noise
    unfinished = _unfinished(residual, slopes) if searched else 1.0
    matters = own > MATTERS and times >= TIMES_NOISE and (surely or unfinished >= UNFINISHED)
    torque = np.concatenate([curve.torque for curve in family])
    constant = float(np.std(torque)) / family.peak
    nothing = own >= HARDLY_BETTER * constant
    explains = max((_saved(residual, slopes, one.column) for one in found), default=1.0)
    wrong = matters or nothing or explains >= TIMES_NOISE
    verdict = NOT if wrong else NOT_BEYOND if beyond else DESCRIBES
    baselines = baseline_errors(family)
    remarks = list(_misfit_remarks(misfit, known, family) if surely else ())
    if nothing:
        remarks.append(
            f"the model explains next to nothing of the torque (NRMSE {own:.2%}, a constant torque "
            f"{constant:.2%}): check the columns, or measure larger motions"
        )
    remarks += _outlier_remarks(residual, sizes)
    for i, cause in enumerate(found):
        both = np.column_stack([slopes, cause.column])
        rest = explained(residual, both, smooth, sizes, known).probability
        if not surely or rest >= UNLIKELY or i == 0:
            remarks.append(cause.sentence if rest >= UNLIKELY else f"perhaps {cause.sentence}")
            if rest >= UNLIKELY:
                break
    if unfinished >= UNFINISHED and own > MATTERS:
        remarks.append(
            f"the search ended before the least error, which is about {1 - 1 / unfinished:.0%} "
            "less: give it more trials or a larger budget, or use the method 'certified'"
        )
    if not surely and known is None and misfit.noise.memory > WANDERS:
        remarks.append(
            f"the residual wanders (correlation {misfit.noise.memory:.2f} from sample to sample), "
            "which may be noise or misfit: measure every curve twice to tell which"
        )
    best = min(baselines, key=lambda name: baselines[name])
    if baselines[best] <= own:
        remarks.append(
            f"the curves are described as well by {best} (NRMSE {baselines[best]:.2%} against "
            f"{own:.2%}): they show no memory that this model would be needed for"
        )
    return Judgement(
        verdict=verdict,
        times_noise=times,
        misfit=misfit,
        noise=misfit.noise,
        causes=tuple(found),
        baselines=baselines,
        remarks=tuple(remarks),
    )


def _reached(slopes: Array) -> Array:
    """Returns the directions in which a fit moves the torque, without those that hardly do."""
    basis, singular, _ = np.linalg.svd(slopes, full_matrices=False)
    return basis[:, singular > HARDLY * singular[0]] if singular.size else basis


def _unfinished(residual: Array, slopes: Array) -> float:
    """Returns the error over the least one that the derivatives of the model promise nearby."""
    basis = independent(slopes)
    least = residual - basis @ (basis.T @ residual)
    return float(np.linalg.norm(residual) / max(np.linalg.norm(least), np.finfo(float).tiny))


def _saved(residual: Array, slopes: Array, column: Array) -> float:
    """Returns the residual over what is left of it where a column of a fault is fitted too."""
    basis = independent(np.column_stack([slopes, column]))
    rest = residual - basis @ (basis.T @ residual)
    return float(np.linalg.norm(residual) / max(np.linalg.norm(rest), np.finfo(float).tiny))


def _outlier_remarks(residual: Array, sizes: Sequence[int]) -> list[str]:
    """Returns a remark about single samples far from their neighbors, if there are any.

    The statistic is the residual less the mean of its two neighbors, which a smooth misfit leaves
    small, over its deviation by the median, which outliers leave as it is.
    """
    parts = np.split(residual, np.cumsum(sizes)[:-1])
    apart = np.concatenate([one[1:-1] - (one[:-2] + one[2:]) / 2 for one in parts])
    scale = 1.4826 * float(np.median(np.abs(apart)))
    if scale == 0:
        return []  # without noise, or so coarse that most samples repeat the one before
    size = np.pad(np.abs(apart), 1)
    peaks = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])  # not the neighbors of outliers
    far = np.abs(apart[peaks & (np.abs(apart) > FAR * scale)])
    if far.size < FEWEST_OUTLIERS:
        return []
    return [
        f"{far.size} samples are up to {far.max():.2g} N·m off their neighbors, more than "
        f"{FAR:g} times what is usual: remove these outliers, or fit against them with --objective "
        "robust of a swarm (--method sa-pso)"
    ]


def _misfit_remarks(misfit: Explained, known: Noise | None, curves: Curves) -> list[str]:
    told = "of repeated curves" if known else "that is estimated beside it"
    share, seldom = misfit.noise.deviation / curves.peak, max(misfit.probability, 1e-9)
    return [
        f"the fit is at least {misfit.times_noise:.2f} times the noise {told} ({share:.2%} of the "
        f"peak), and noise alone leaves so smooth a residual in at most {seldom:.0e} of all fits "
        f"(told below {UNLIKELY:g}): check columns, order and begin of the curves, or choose "
        "another model (method 'auto')"
    ]
