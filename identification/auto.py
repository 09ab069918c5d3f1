"""Which model to identify: the simplest of those that predict curves they were not fitted to."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..errors import InputError, at_least
from ..hysteresis.asymmetric import Asymmetric
from ..hysteresis.bouc_wen import BoucWen
from ..hysteresis.held import Held
from ..hysteresis.jiles_atherton import JilesAtherton
from ..hysteresis.model import HysteresisModel
from ..hysteresis.prandtl_ishlinskii import PrandtlIshlinskii
from ..hysteresis.preisach import Preisach
from .asymmetric_fit import fit_asymmetric
from .bouc_wen_fit import fit_bouc_wen
from .certified import certified_fit
from .curves import Curve
from .direct import fit_prandtl_ishlinskii, fit_preisach

Array = NDArray[np.float64]
Fitter = Callable[[Sequence[Curve], np.random.Generator], HysteresisModel]

AS_GOOD = 1.1  # times the best score: among those the model with fewest parameters is chosen


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One model that `identify_auto` tried.

    Attributes:
        name: of the model.
        model: fitted to all curves; None where that failed.
        first_torque: the torque at the beginning of a curve as identified [N·m].
        parameters: how many numbers the fit chooses.
        prediction_nrmse: over curves left out of the fit; infinite where it failed.
        fit_nrmse: on the fitted curves; infinite where it failed.
        reason: why it failed, as a sentence; empty if it did not.
    """

    name: str
    model: HysteresisModel | None = None
    first_torque: float = 0.0
    parameters: int = 0
    prediction_nrmse: float = float("inf")
    fit_nrmse: float = float("inf")
    reason: str = ""


@dataclass(frozen=True, kw_only=True)
class AutoFit:
    """What `identify_auto` found.

    Attributes:
        model: the chosen model, fitted to all curves with role "fit".
        name: the candidate it is.
        first_torque: the torque at the beginning of a curve as identified [N·m];
            `model.response(angle, first_torque)` predicts a curve of the same family.
        candidates: all that were tried, the best prediction first.
        why: the reason of the choice, as a sentence.
    """

    model: HysteresisModel
    name: str
    first_torque: float
    candidates: tuple[Candidate, ...]
    why: str


def identify_auto(curves: Sequence[Curve], *, seed: int = 0) -> AutoFit:
    """Identifies the model that predicts best, or a simpler one that predicts nearly as well.

    Each candidate is fitted to all curves but one and predicts that one, for each in turn but the
    one that reaches farthest: no curve tells a model of many weights what lies beyond it, and a
    score of such a guess would decide against it whatever it does inside. The NRMSE of all these
    predictions is the score. Of the models within 10 % of the best score the one with fewest
    parameters is chosen, and fitted to all curves. Everything a prediction uses, the torque at its
    beginning too, comes from the other curves.

    Candidates are Jiles-Atherton, the same beside a cubic polynomial, Bouc-Wen,
    Prandtl-Ishlinskii and Preisach, all restricted to certified, dissipative models.

    Args:
        curves: first-order curves; those with role "fit" are used, at least 2, better 3, and 5 or
            more for the models of many weights.
        seed: fixes all random numbers.

    Raises:
        InputError: there are too few curves, or no candidate could be fitted.
    """
    at_least("seed", seed, 0)
    measured = [curve for curve in curves if curve.role == "fit"]
    if len(measured) < 2:
        raise InputError(
            f"the number of curves with role 'fit' is {len(measured)}: a choice among models needs "
            "at least 2, better 3, so that one can be left out and predicted"
        )
    tried = [_candidate(name, fit, measured, seed) for name, fit in CANDIDATES.items()]
    tried.sort(key=lambda candidate: candidate.prediction_nrmse)
    best = tried[0]
    if best.model is None:
        reasons = "; ".join(f"{candidate.name}: {candidate.reason}" for candidate in tried)
        raise InputError(f"no model could be fitted to these curves ({reasons})")
    good = [one for one in tried if one.prediction_nrmse <= AS_GOOD * best.prediction_nrmse]
    chosen = min(good, key=lambda candidate: candidate.parameters)
    assert chosen.model is not None  # its score is finite
    return AutoFit(
        model=chosen.model,
        name=chosen.name,
        first_torque=chosen.first_torque,
        candidates=tuple(tried),
        why=_why(chosen, tried),
    )


def first_torque(model: HysteresisModel, curves: Sequence[Curve]) -> float:
    """Returns the torque [N·m] with which a model that begins all curves fits them best.

    One measured sample would bring its whole noise into a prediction.

    Raises:
        InputError: the model cannot begin so.
    """

    def residual(torque: Array) -> Array:
        return _errors(model, float(torque[0]), curves)

    guess = np.mean([curve.torque[0] for curve in curves])
    size = max(float(np.abs(curve.torque).max()) for curve in curves)
    result = least_squares(residual, [guess], x_scale=size)
    return float(result.x[0])


def _jiles_atherton(curves: Sequence[Curve], rng: np.random.Generator) -> HysteresisModel:
    fit = certified_fit(curves, rng=rng)
    Ms, a, alpha, c, k = fit.parameters.tolist()
    model = JilesAtherton(Ms=Ms, a=a, alpha=alpha, c=c, k=k, angle_unit="deg")
    return Held(model=model, angle_range=fit.held) if fit.held else model


CANDIDATES: dict[str, Fitter] = {
    "jiles-atherton": _jiles_atherton,
    "asymmetric": fit_asymmetric,
    "bouc-wen": fit_bouc_wen,
    "prandtl-ishlinskii": lambda curves, rng: fit_prandtl_ishlinskii(curves),
    "preisach": lambda curves, rng: fit_preisach(curves),
}


def _candidate(name: str, fit: Fitter, curves: Sequence[Curve], seed: int) -> Candidate:
    def fitted(some: Sequence[Curve]) -> tuple[HysteresisModel, float]:
        model = fit(some, np.random.default_rng(seed))
        # The fit of the bare Jiles-Atherton model takes first-order curves by their definition.
        return model, 0.0 if name == "jiles-atherton" else first_torque(model, some)

    try:
        errors = []
        for left_out in _left_out(curves):
            model, torque = fitted([curve for curve in curves if curve is not left_out])
            errors.append(_errors(model, torque, [left_out]))
        model, torque = fitted(curves)
        on_fit = _errors(model, torque, curves)
    except InputError as error:
        return Candidate(name=name, reason=str(error))
    peak = max(float(np.abs(curve.torque).max()) for curve in curves)
    return Candidate(
        name=name,
        model=model,
        first_torque=torque,
        parameters=_parameters(model),
        prediction_nrmse=_rms(np.concatenate(errors)) / peak,
        fit_nrmse=_rms(on_fit) / peak,
    )


def _left_out(curves: Sequence[Curve]) -> list[Curve]:
    """Returns the curves that the others can predict without extrapolation."""
    reach = [float(np.abs(curve.angle - curve.angle[0]).max()) for curve in curves]
    farthest = int(np.argmax(reach))
    return [*curves[:farthest], *curves[farthest + 1 :]]


def _errors(model: HysteresisModel, torque: float, curves: Sequence[Curve]) -> Array:
    return np.concatenate([model.response(curve.angle, torque) - curve.torque for curve in curves])


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def _parameters(model: HysteresisModel) -> int:
    """Returns how many numbers a fit of the model chooses."""
    match model:
        case Held(model=inner):
            return _parameters(inner)
        case Asymmetric(model=inner, polynomial=polynomial):
            return _parameters(inner) + len(polynomial)
        case BoucWen():
            return 6  # all but A, which is 1
        case PrandtlIshlinskii(weights=weights):
            return 2 + len(weights)
        case Preisach(density=density, elastic=elastic):
            return len(elastic) + sum(len(row) for row in density)
    return 5  # Jiles-Atherton


def _why(chosen: Candidate, tried: Sequence[Candidate]) -> str:
    best = tried[0]
    score = f"with NRMSE {chosen.prediction_nrmse:.2%}"
    if chosen is not best:
        return (
            f"{chosen.name} predicts curves left out of its fit {score}, within 10 % of the best "
            f"({best.name}, {best.prediction_nrmse:.2%}), and has fewer parameters "
            f"({chosen.parameters} instead of {best.parameters})"
        )
    text = f"{chosen.name} predicts curves left out of its fit best, {score}"
    if tried[1].model is None:
        return f"{text}; no other model could be fitted"
    return (
        f"{text} (next is {tried[1].name}, {tried[1].prediction_nrmse:.2%}), and no model within "
        f"10 % of that has fewer parameters than its {chosen.parameters}"
    )
