"""The result of an identification: a model, its errors, its verdict and remarks."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np

from ..arrays import Array
from ..hysteresis.around import Asymmetric, Backlash, Clipped, Viscoelastic, without_rate
from ..hysteresis.jiles_atherton.model import PARAMETERS, JilesAtherton
from ..hysteresis.protocol import HysteresisModel
from ..published import LI_BOUNDS
from .corrections.corrections import Corrected, Corrections
from .corrections.softening import Softening
from .data.curves import Curve, Curves
from .data.parts import FITTED
from .fits.certified import EXCESS, SHAPE
from .fits.magnetic import FORMS
from .fits.objective import Fitted, InitialTorque, nrmse, predicted, torque_errors
from .fits.parameters import FREE, Constraints, Parameter, parameters_of
from .fits.registry import LARGEST, play_of, rate_of, without_play
from .fits.search import MARGIN
from .judging.coverage import NESTED, Coverage, coverage, shortfalls
from .judging.judgement import Judgement, judge
from .judging.recording import IF_WRONG, recording_faults
from .judging.sentences import NOT, UNKNOWN, Remark
from .judging.uncertainty import Uncertainty, uncertainty
from .methods import Magnetic, Method, Search

ALIKE = 9.0  # twice the log likelihood by which a form is surely better: three deviations, squared
MOST_NAMED = 3  # parameters in one remark
NEAR = 1e-3  # relative distance at which a parameter counts as being at its limit
DISORDER = 0.2  # largest plausible error, as a share of the peak
AWAY, BESIDE = 5.0, 0.02  # tolerance in deviations of the noise, and as a share of the peak


@dataclass(frozen=True, kw_only=True)
class Trial(Fitted):
    """One independent run of a method: a `Fitted` with its number and its NRMSE.

    Attributes:
        index: The number of the trial, which determines its random numbers.
        nrmse: Error sqrt(mean((Tc - Tm)^2)) / max|Tm| on the fitted curves.
    """

    index: int
    nrmse: float


@dataclass(frozen=True, kw_only=True)
class Fit:
    """A model identified from curves, with its verdict: result of `fit_curves`.

    Attributes:
        model: The best trial's model; if the model is safe at the fitted angles only, its torque is
            constant outside them.
        model_name: The name of the model.
        method: The name of the method that found the model.
        initial_torque: The torque with which all curves begin [N·m]; or "measured": each begins
            with its first sample.
        fitness: Eq. (7) of Li et al. 2022 on the fitted curves.
        nrmse: Error sqrt(mean((Tc - Tm)^2)) / max|Tm| on the fitted curves.
        prediction_errors: The largest |Tc - Tm| [N·m] on each curve with role "predict"; infinity
            where the model meets its pole.
        trials: Every finished trial, by index.
        curves: All measured curves, less the tare. A fitted softening is removed: the torques are
            those of the end of the measurement.
        fitted_curves: The curves that the fit used, thinned if they are long.
        remarks: Reasons to doubt the model; empty if there are none.
        interrupted: Whether Ctrl-C ended the fit before all trials, or models, were finished.
        fitted_start: Whether the initial torque was fitted too.
        coverage: Range, reversals, rates and cycles of the fitted curves.
        shortfalls: Requirements of the intended motions that the curves do not cover.
        tare: Offset of the torque sensor that was subtracted from the curves [N·m].
        softening: Change of the torque over the cycles that was removed from the curves, if any.
        constraints: Parameters that the user fixed or bounded.
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
    fitted_curves: Curves = field(repr=False, compare=False)
    remarks: tuple[Remark, ...] = ()
    interrupted: bool = False
    fitted_start: bool = False
    judgement: Judgement | None = field(default=None, compare=False)
    coverage: Coverage | None = None
    shortfalls: tuple[Remark, ...] = ()
    tare: float = 0.0
    softening: Softening | None = None
    constraints: Constraints = FREE

    @property
    def evaluations(self) -> int | None:
        """Model evaluations of all trials together; None if the fit does not count them."""
        counts = [trial.evaluations for trial in self.trials]
        return None if None in counts else sum(cast(list[int], counts))

    @property
    def agreed(self) -> int | None:
        """Number of starts from which the best trial found its model; None for a single start."""
        return self._best_trial.agreed

    @property
    def starts(self) -> int | None:
        """Number of starts of the best trial; None for a single start."""
        return self._best_trial.starts

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters of the model that the fit chose, or that the user fixed."""
        return parameters_of(self.model, self.constraints)

    @property
    def _best_trial(self) -> Trial:
        return min(self.trials, key=lambda trial: (trial.loss, trial.index))

    def predict(self, curve: Curve) -> Array:
        """Returns the torque [N·m] along a curve, begun as in the fit; infinite at a pole."""
        return predicted(self.model, self.initial_torque, curve)

    @property
    def verdict(self) -> str:
        """Whether the model describes the curves, as a phrase; see `judging.judgement`."""
        return NOT if self.judgement is None else self.judgement.verdict

    def uncertainty(self, *, samples: int = 0, seed: int = 0) -> Uncertainty:
        """Returns the uncertainty of the parameters and of the torque of the model.

        Args:
            samples: Number of models to draw, as fits to noisy repetitions of the curves would give
                them.
            seed: Seed of their noise.
        """
        return uncertainty(
            self.model,
            self.fitted_curves,
            initial_torque=self.initial_torque,
            fitted_start=self.fitted_start,
            constraints=self.constraints,
            samples=samples,
            seed=seed,
        )


def judged_fit(
    curves: Corrected,
    corrections: Corrections,
    model_name: str,
    method: Method | str,
    trials: Sequence[Trial],
    needed: Coverage | None,
    *,
    constraints: Constraints,
    fitted_start: bool,
    interrupted: bool,
    memoryless: Remark | None = None,
) -> Fit:
    """Returns the best of the finished trials with its errors, its verdict and all remarks.

    `fitted_start` is whether the fit chose the torque with which the curves begin, and `memoryless`
    is a remark that no hysteresis model is needed.
    """
    measured = curves.family.fitted()
    best = min(trials, key=lambda trial: (trial.loss, trial.index))
    errors = {
        curve.name: float(np.abs(torque_errors(best.model, best.initial_torque, [curve])).max())
        for curve in curves.family.held_out()
    }
    samples, used = (sum(one.angle.size for one in some) for some in (measured, curves.measured))
    score = best.nrmse
    if used < samples:
        score = nrmse(torque_errors(best.model, best.initial_torque, measured), measured)
    covered = coverage(measured)
    short = shortfalls(covered, needed) if needed else []
    is_search = isinstance(method, Search)
    judged = judge(
        best.model,
        best.initial_torque,
        curves.judged,
        fitted_start=fitted_start,
        constraints=constraints,
        beyond=bool(short) if needed else covered.nesting < NESTED,
        searched=is_search and method.objective != "robust" and method.normalize != "curve",
    )
    if memoryless and judged:
        judged = replace(judged, verdict=NOT, remarks=(memoryless, *judged.remarks))
    doubted = judged is None or judged.verdict in (NOT, UNKNOWN)
    faults = recording_faults(curves.read.fitted())
    remarks = [one for one in faults if doubted or one.code not in IF_WRONG]
    remarks += diagnostics(best.model, score, measured, LI_BOUNDS if is_search else None)
    remarks += _at_bounds(parameters_of(best.model, constraints))
    remarks += judged.remarks if judged else ()
    if isinstance(method, Magnetic):
        remarks += _alike_forms(trials, measured)
    remarks += short
    if judged and not fitted_start:
        remarks += _begins_elsewhere(best.initial_torque, measured, judged.noise.deviation)
    if used < samples:
        thinned = {"used": used, "samples": samples, "every": -(-samples // FITTED)}
        remarks.insert(0, Remark("thinned", thinned))
    remarks += _on_corrections(corrections, best.model, curves.softening)
    return Fit(
        model=best.model,
        model_name=model_name,
        method=method if isinstance(method, str) else method.name,
        initial_torque=best.initial_torque,
        fitness=score / float(np.sqrt(sum(curve.angle.size for curve in measured))),
        nrmse=score,
        prediction_errors=errors,
        trials=tuple(sorted(trials, key=lambda trial: trial.index)),
        curves=curves.family,
        fitted_curves=curves.measured,
        remarks=tuple(remarks),
        interrupted=interrupted,
        fitted_start=fitted_start,
        judgement=judged,
        coverage=covered,
        shortfalls=tuple(short),
        tare=curves.tare,
        softening=curves.softening,
        constraints=constraints,
    )


def _on_corrections(
    corrections: Corrections, model: HysteresisModel, change: Softening | None
) -> Iterator[Remark]:
    """Yields remarks on requested corrections that were not found, or found in part.

    `change` is the change over the cycles that was found.
    """
    if corrections.softening == "fit" and change is None:
        yield Remark("softening none")
    if change is not None and not change.is_complete:
        yield Remark("softening incomplete", {"cycles": change.measured, "steady": change.steady})
    if corrections.play == "fit" and play_of(model) == "none":
        yield Remark("play none")
    if isinstance(model, Viscoelastic) and rate_of(model) == "viscous":
        if model.damping == 0:
            yield Remark("rate none")
        elif corrections.rate == "relaxing":
            yield Remark("rate viscous")


def diagnostics(
    model: HysteresisModel,
    nrmse: float,
    curves: Sequence[Curve],
    bounds: Sequence[tuple[float, float]] | None,
) -> Iterator[Remark]:
    """Yields remarks on a large error and on parameters at a limit.

    The bounds are the search box of Ms, a, alpha, c, k in degrees; None for certified fits.
    """
    if nrmse > DISORDER:
        yield Remark("disorder error", {"nrmse": nrmse})
    span = max(float(np.ptp(curve.angle)) for curve in curves)
    inner = without_rate(model)
    if isinstance(inner, Backlash) and inner.gap >= (1 - NEAR) * LARGEST * span:
        yield Remark("limit gap", {"gap": inner.gap})
    inner = without_play(inner)
    inner = inner.model if isinstance(inner, Asymmetric) else inner
    if isinstance(inner, Clipped):
        low, high = inner.angle_range
        yield Remark("range", {"low": low, "high": high})
        if inner.certificate().margin <= MARGIN + NEAR:
            yield Remark("certificate")
        inner = inner.model
    if isinstance(inner, JilesAtherton) and inner.clamp == "none":  # other boxes in magnetics
        yield from _limits(inner.in_unit("deg"), bounds)


def _limits(model: JilesAtherton, bounds: Sequence[tuple[float, float]] | None) -> Iterator[Remark]:
    limits: dict[str, tuple[float, float]] = {"a": SHAPE, "c": (1 + EXCESS[0], 1 + EXCESS[1])}
    if bounds:
        limits = dict(zip(PARAMETERS, bounds, strict=True))
    for name, pair in limits.items():
        value = getattr(model, name)
        for limit in pair:
            if abs(value - limit) <= NEAR * max(1.0, abs(limit)):
                yield Remark("limit", {"name": name, "value": value, "limit": limit})


def _begins_elsewhere(start: InitialTorque, curves: Curves, noise: float) -> Iterator[Remark]:
    """Yields a remark if the curves begin at another torque than the model."""
    first, most = curves.start_torque, max(AWAY * noise, BESIDE * curves.peak)
    if not isinstance(start, str) and abs(first - start) > most:
        yield Remark("start", {"curves": first, "model": start})


def _at_bounds(parameters: Iterable[Parameter]) -> list[Remark]:
    """Returns a remark on the parameters that ended at a bound of the user."""
    ended = [f"{one.name} = {one.value:.5g}" for one in parameters if one.state == "at its bound"]
    if not ended:
        return []
    shown = ", ".join(ended[:MOST_NAMED]) + (", ..." if len(ended) > MOST_NAMED else "")
    return [Remark("limit given", {"names": shown})]


def _alike_forms(trials: Sequence[Trial], curves: Curves) -> list[Remark]:
    """Returns a remark if the curves do not distinguish the best form from others."""
    samples = sum(curve.torque.size for curve in curves)
    best, *others = sorted(trials, key=lambda trial: (trial.loss, trial.index))
    alike = [
        f"{FORMS[one.index]!r} ({one.loss:.2%})"
        for one in others
        if 2 * samples * np.log(one.loss / best.loss) < ALIKE
    ]
    form = f"{FORMS[best.index]!r} (NRMSE {best.loss:.2%})"
    return [Remark("form", {"form": form, "others": " and ".join(alike)})] if alike else []
