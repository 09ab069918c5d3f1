"""The models that the curves do not distinguish, and a band of the torque over all of them.

Models that agree on the curves may differ beyond them, and a model that fits at the noise may be of
another kind than the joint. So a band of the torque has two parts: the spread of the models that
predict left-out curves nearly as well as the best, and the error of these predictions in excess of
the noise. The spread alone is too small, because of effects that no model has.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ndtri

from ...arrays import Array
from ...checks import at_least, check_seed, number
from ...errors import InputError, shown
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve, Curves
from ..data.files import Motion
from ..fits.certified import begins_safely
from ..fits.objective import InitialTorque, predicted, torque_errors
from ..fits.parameters import FREE, Constraints
from ..fits.registry import fit_model
from .coverage import NESTED, motion_coverage
from .noise import GRID, Noise
from .sentences import Remark
from .uncertainty import Uncertainty, uncertainty

NEARLY = 1.3  # largest left-out error of a member, relative to the least one
SHARPNESS = 2  # power of weights; with 1 bands are wider in the class, and cover hardly more
LEVEL = 0.9  # default level of a band
LIMIT = 0.95  # probability below the upper limit of the excess
NARROW = 0.05  # half width over the peak; a larger error needs repeats in a verdict, too


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One model that `select` tried. If its fit failed, its errors are infinite."""

    name: str
    model: HysteresisModel | None  # fitted to all curves; None if the fit failed
    initial_torque: InitialTorque = 0.0  # with which the curves begin [N·m]
    fitted_start: bool = False  # whether the fit chose that torque
    parameters: int = 0  # number that the fit chooses
    prediction_nrmse: float = float("inf")  # of the left-out data
    fit_nrmse: float = float("inf")  # on the fitted curves
    reason: str = ""  # why the fit failed, as a sentence
    # Errors of the predictions [N·m]: all left-out samples, end to end in one order.
    prediction_errors: Array = field(default_factory=lambda: np.empty(0), repr=False, compare=False)


@dataclass(frozen=True, kw_only=True)
class Member(Candidate):
    """A candidate in an ensemble.

    Attributes:
        error: Root mean square error of its predictions of left-out curves [N·m].
        weight: Share in the mean of the ensemble, proportional to the inverse square of the upper
            limit of the squared error beyond the noise. This limit is the squared `excess` of the
            best member, plus the difference of the squared errors of both.
    """

    model: HysteresisModel
    error: float
    weight: float


@dataclass(frozen=True, kw_only=True)
class Ensemble:
    """The models whose left-out error is at most 1.3 times the least, the best one first.

    Attributes:
        members: Models with their weights, whose sum is 1.
        excess: Deviation that the best member may have from the joint [N·m]: the root of the upper
            95 % limit of its squared error less the squared noise.
        nested: Names of the curves with nested loops, which fits to the other curves predicted. The
            excess is that of these predictions; without such curves, that of all left-out curves.
        tested: Whether any left-out data had nested loops.
        noise: Noise of the measured torque.
    """

    members: tuple[Member, ...]
    excess: float
    nested: tuple[str, ...]
    tested: bool
    noise: Noise = field(repr=False, compare=False)

    def band(self, curve: Curve, level: float = LEVEL) -> tuple[Array, Array]:
        """Returns the ends of a band of the torque along a curve [N·m], shape (samples,) each.

        The band is about the mean of the members. Half its width is the normal quantile times the
        root of their variance and the squared excess. It is about the torque without noise, at the
        angles and rates of the fitted curves; where a member meets its pole it is infinite.

        Args:
            curve: Motion; its torque is used only where the fit began with the measured one.
            level: Share of the samples that the band is to contain, between 0 and 1.
        """
        if not isinstance(curve, Curve):
            raise InputError(f"curve is {shown(curve)}: give a Curve, whose torque may be zeros")
        if not 0 < number("level", level) < 1:
            raise InputError(f"level is {level:g}: give a share between 0 and 1, such as 0.9")
        if not self.tested and (depth := _nesting(curve)) >= NESTED:
            raise InputError(
                f"the motion has loops inside loops ({depth} reversals deep), and the curves have "
                "none, on which the models could be tested: there is no band; measure also the "
                "record that `nested_motion` (activesuit design) gives"
            )
        torque = np.array([predicted(one.model, one.initial_torque, curve) for one in self.members])
        if not np.isfinite(torque).all():
            endless = np.full(curve.angle.size, np.inf)
            return -endless, endless
        weight = np.array([one.weight for one in self.members])
        mean = weight @ torque
        variance = weight @ (torque - mean) ** 2
        if len(weight) > 1:
            variance = variance * len(weight) / (len(weight) - 1)
        half = ndtri((1 + level) / 2) * np.sqrt(variance + self.excess**2)
        return mean - half, mean + half

    def measured_band(self, curve: Curve) -> tuple[Array, Array]:
        """Returns the ends of a 90 % band of measured torque, wider by the noise; see `band`."""
        low, high = self.band(curve)
        middle = (low + high) / 2
        noise = self.noise.deviation * self.noise.uneven.at(middle)
        half = np.hypot((high - low) / 2, ndtri((1 + LEVEL) / 2) * noise)
        return middle - half, middle + half

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        return {
            "members": [
                {
                    "name": one.name,
                    "weight": one.weight,
                    "prediction_error": one.error,
                    "initial_torque": one.initial_torque,
                    "model": one.model.to_dict(),
                }
                for one in self.members
            ],
            "excess": self.excess,
            "nested": self.nested,
            "tested": self.tested,
            "noise": self.noise.deviation,
        }


def ensemble(
    candidates: Sequence[Candidate],
    curves: Sequence[Curve],
    noise: Noise,
    *,
    seed: int,
    options: Mapping[str, Mapping[str, Any]],
) -> Ensemble | None:
    """Joins the candidates that predict left-out curves nearly as well as the best.

    Curves with nested loops test the models beyond first-order curves: every candidate is fitted to
    all other curves, and its errors on the nested ones count with its other left-out errors. The
    result is None if every candidate meets its pole on a left-out curve.
    """
    tried = [one for one in candidates if one.model and np.isfinite(one.prediction_nrmse)]
    if not tried:
        return None
    nested = [curve for curve in curves if _nesting(curve) >= NESTED]
    others = [curve for curve in curves if curve not in nested]
    if not others:
        nested = []  # the left-out curves are nested themselves
    tested = bool(nested) or not others
    beyond: dict[str, Array] = {}
    for one in tried:
        errors = _errors(one.name, others, nested, seed, options.get(one.name, {}))
        if errors is not None:
            beyond[one.name] = errors
    if not beyond:
        tested = tested and not nested
        nested, beyond = [], {one.name: np.empty(0) for one in tried}
    left_out = {one.name: one.prediction_errors for one in tried}
    errors_of = {name: np.concatenate([left_out[name], more]) for name, more in beyond.items()}
    score = {name: math.sqrt(np.mean(errors**2)) for name, errors in errors_of.items()}
    best = min(score, key=lambda name: score[name])
    kept = [one for one in tried if score.get(one.name, math.inf) <= NEARLY * score[best]]
    kept.sort(key=lambda one: score[one.name])
    limit = excess(beyond[best] if nested else errors_of[best], noise)
    far = np.array([score[one.name] ** 2 - score[best] ** 2 + limit**2 for one in kept])
    far += np.finfo(float).tiny
    weight = (far.min() / far) ** SHARPNESS
    return Ensemble(
        members=tuple(
            Member(**vars(one), error=score[one.name], weight=share)
            for one, share in zip(kept, (weight / weight.sum()).tolist(), strict=True)
        ),
        excess=limit,
        nested=tuple(curve.name for curve in nested),
        tested=tested,
        noise=noise,
    )


def drawn(
    found: Ensemble,
    measured: Curves,
    initial_torque: InitialTorque,
    samples: int,
    seed: int,
    constraints: Constraints = FREE,
) -> list[Uncertainty]:
    """Returns the uncertainties of the members, which share the models to draw.

    Each model is a refit of a member to its own curves with new noise and systematic errors.
    Members share the number in proportion to their weights; members that cannot begin with the
    torque [N·m] of the joint are left out.
    """
    at_least("samples", samples, 0)
    check_seed(seed)
    start = measured.start_torque if isinstance(initial_torque, str) else initial_torque
    can_begin = [one for one in found.members if begins_safely(one.model, start, measured)]
    weights = np.array([one.weight for one in can_begin])
    # Whole numbers in proportion to the weights, by the largest remainder.
    wanted = samples * weights / weights.sum() if can_begin else weights
    counts = np.floor(wanted).astype(int)
    counts[np.argsort(counts - wanted, kind="stable")[: samples - counts.sum()]] += 1
    return [
        uncertainty(
            one.model,
            measured,
            initial_torque=one.initial_torque,
            fitted_start=one.fitted_start,
            constraints=constraints,
            samples=count,
            seed=seed + i,
        )
        for i, (one, count) in enumerate(zip(can_begin, counts.tolist(), strict=True))
        if count
    ]


def excess(errors: Array, noise: Noise) -> float:
    """Returns the root of an upper limit of the mean squared error less the squared noise [N·m].

    The mean square of n samples of noise has the variance 2 (sum of squared correlations) / n of
    the squared variance; slow noise has few independent samples. Errors are predicted less measured
    torque [N·m].
    """
    memory, white = GRID.T
    alike = 1 + 2 * ((1 - white) * memory) ** 2 / (1 - memory**2)
    count = min(errors.size, noise.freedom)  # no more samples than the noise was estimated from
    lower = 1 - ndtri(LIMIT) * np.sqrt(2 * alike / count)
    least = float(noise.weight @ (noise.variance * np.maximum(lower, 0)))
    return math.sqrt(max(float(np.mean(errors**2)) - least, 0))


def _nesting(curve: Curve) -> int:
    return motion_coverage([Motion(curve.time, curve.angle)]).nesting


def _errors(
    name: str, others: Sequence[Curve], nested: Sequence[Curve], seed: int, options: Mapping
) -> Array | None:
    """Returns the errors of a model on curves outside its fit; None if it cannot predict them."""
    if not nested:
        return np.empty(0)
    try:
        found = fit_model(name, others, np.random.default_rng(seed), **options)
        errors = torque_errors(found.model, found.initial_torque, nested)
    except InputError:
        return None
    return errors if np.isfinite(errors).all() else None


class Agreement(NamedTuple):
    """How far kinds of model differ on motions.

    The half width [N·m] is the largest mean of a motion's band; without a band half the difference
    of the models, and infinite where they cannot be compared.
    """

    half_width: float
    tested: bool  # whether that is the width of a band that left-out curves have tested
    remark: Remark

    @property
    def sentence(self) -> str:
        """The agreement in words."""
        return self.remark.sentence


def agreement(found: Ensemble, motions: Sequence[Motion], peak: float) -> Agreement | None:
    """Returns how far the members of an ensemble differ on motions; None if no motion moves.

    The peak is the largest torque of the curves [N·m].
    """
    moving = [one for one in motions if np.ptp(one.angle) > 0]
    if not moving:
        return None
    try:
        curves = [
            Curve(one.angle, np.zeros(len(one.angle)), f"motion {i}", time=one.time)
            for i, one in enumerate(moving)
        ]
        bands, tested = _bands(found, curves)
    except InputError as error:
        return Agreement(math.inf, False, Remark("agreement unknown", {"why": str(error)}))
    half = max(float(np.mean(high - low)) / 2 for low, high in bands)
    if not math.isfinite(half):
        why = "one of them meets its pole there"
        return Agreement(half, False, Remark("agreement unknown", {"why": why}))
    by = f"curve {found.nested[0]!r}" if found.nested else "left-out curves"
    values = {"half_width": half, "share": half / peak, "level": LEVEL, "by": by}
    kind = "agreement tested" if tested else "agreement"
    return Agreement(half, tested, Remark(kind, values | {"members": len(found.members)}))


def _bands(found: Ensemble, curves: Sequence[Curve]) -> tuple[list[tuple[Array, Array]], bool]:
    """Returns the bands along curves, and whether left-out curves have tested such bands."""
    try:
        return [found.band(curve) for curve in curves], True
    except InputError:
        if found.tested:
            raise
    bands = []
    for curve in curves:
        torque = [predicted(one.model, one.initial_torque, curve) for one in found.members]
        bands.append((np.min(torque, axis=0), np.max(torque, axis=0)))
    return bands, False
