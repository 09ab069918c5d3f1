"""The methods of `identify`: the certified fit, searches by optimizers, and a fit of magnetics."""

import inspect
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, cast

from ..checks import at_least
from ..errors import InputError, unknown_name
from ..hysteresis.jiles_atherton.model import JilesAtherton
from .corrections.corrections import Corrections
from .fits import magnetic
from .fits.objective import InitialTorque, Loss, Normalize
from .fits.registry import FITS
from .swarms.variants import OPTIMIZERS, options_of

DEFAULT_MODEL = JilesAtherton.name  # the only model that every method can identify
SET_BY_IDENTIFY = (
    *("curves", "objective", "bounds", "callback", "constraints", "rng", "initial_torque"),
)
TRIALS = 30  # number of runs of an optimizer, as in Li et al. 2022


@dataclass(frozen=True, init=False)
class Certified:
    """Least squares that return certified models only (ours), for every kind of model.

    Attributes:
        trials: Number of runs from different random numbers.
        options: Options of the model's fit, such as `budget`.
    """

    name: ClassVar[str] = "certified"

    trials: int
    options: Mapping[str, Any]

    def __init__(self, *, trials: int = 1, **options: Any) -> None:
        at_least("trials", trials, 1)
        object.__setattr__(self, "trials", trials)
        object.__setattr__(self, "options", options)


@dataclass(frozen=True, init=False)
class Search:
    """A search of the Jiles-Atherton parameters in the bounds of Table 1 of Li et al. 2022.

    Attributes:
        name: Swarm as published, "pso", "sa-pso", "mpso" or "rank-distance-mpso"; or the name of
            an optimizer that `register_optimizer` made known.
        objective: Loss of `CurveObjective` to minimize.
        normalize: Whether the objective divides errors by the largest torque of the "family" or of
            each "curve".
        trials: Number of runs from different random numbers.
        options: Options of the swarm or optimizer (`swarm_size`, `temperature`, ...).
    """

    name: str
    objective: Loss
    normalize: Normalize
    trials: int
    options: Mapping[str, Any]

    def __init__(
        self,
        name: str,
        *,
        objective: Loss = "nrmse",
        normalize: Normalize = "family",
        trials: int = TRIALS,
        **options: Any,
    ) -> None:
        at_least("trials", trials, 1)
        if name not in OPTIMIZERS:
            raise unknown_name("method", name, OPTIMIZERS)
        given = {"name": name, "objective": objective, "normalize": normalize}
        for key, value in (given | {"trials": trials, "options": options}).items():
            object.__setattr__(self, key, value)


@dataclass(frozen=True, kw_only=True)
class Magnetic:
    """Least squares over the forms of Jiles-Atherton, for magnetization over a field.

    Each form is one trial, with the clamp of magnetics and 0 <= c < 1. Such a model feeds energy
    into a joint, and has no certificate.

    Attributes:
        budget: Largest number of evaluations of the model on all curves, for each form.
    """

    name: ClassVar[str] = "magnetic"
    trials: ClassVar[int] = len(magnetic.FORMS)

    budget: int = magnetic.BUDGET


Method = Certified | Search | Magnetic


def method_names() -> list[str]:
    """Returns the names of all methods, registered optimizers included."""
    return ["certified", "magnetic", *OPTIMIZERS]


def method_of(
    given: str | Method,
    *,
    trials: int | None = None,
    objective: str | None = None,
    normalize: str | None = None,
) -> Method:
    """Returns a method from its name and plain values; None stands for a default value."""
    if isinstance(given, Method):
        return given
    if given not in method_names():
        raise unknown_name("method", given, method_names())
    runs: dict[str, Any] = {} if trials is None else {"trials": trials}
    goal = {"objective": objective, "normalize": normalize}
    goal = {name: value for name, value in goal.items() if value is not None}
    if given in OPTIMIZERS:
        return Search(given, **cast(Any, goal), **runs)
    for name, value in goal.items():
        raise InputError(
            f"{name} is {value!r}: method {given!r} always minimizes the NRMSE over the family; "
            "leave it out, or use a swarm or a baseline"
        )
    if given == Magnetic.name:
        if trials is not None:
            raise InputError(f"trials is {trials}: method {given!r} has one per form; leave it out")
        return Magnetic()
    return Certified(**runs)


def check_together(
    method: Method, model: str, corrections: Corrections, initial_torque: InitialTorque | None
) -> None:
    """Refuses a method, a model, corrections and a beginning that do not go together."""
    if model not in FITS:
        raise unknown_name("model", model, FITS)
    fitted: dict[str, Any] = {}  # corrections that only the certified fit finds
    if isinstance(method, Certified):
        taken = inspect.signature(FITS[model]).parameters
        if method.trials > 1 and "rng" not in taken:
            raise InputError(
                f"trials is {method.trials}: the fit of {model!r} is made once; leave it out"
            )
        _check_options(method, taken)
    elif model != DEFAULT_MODEL:
        raise InputError(
            f"method is {method.name!r}: model {model!r} has the method 'certified' only"
        )
    elif isinstance(method, Search):  # which takes tare and softening from the certified fit
        _check_options(method, options_of(method.name))
        fitted = corrections.beside
    else:
        asked = {"tare": corrections.tare, "softening": corrections.softening}
        fitted = {name: "fit" for name, value in asked.items() if value == "fit"}
        fitted = corrections.beside | fitted
    for name, value in fitted.items():
        raise InputError(
            f"{name} is {value!r}, which the method {method.name!r} does not fit: use the method "
            f"'certified', or leave {name} out"
        )
    if model != DEFAULT_MODEL:
        check_beginning(initial_torque)


def check_beginning(initial_torque: InitialTorque | None) -> None:
    """Refuses a given torque at the beginning of curves, where fits identify it."""
    if initial_torque not in (None, "identified"):
        raise InputError(
            f"initial_torque is {initial_torque!r}: the fits of other models than "
            f"{DEFAULT_MODEL!r} identify it; leave it out"
        )


def _check_options(method: Certified | Search, names: Iterable[str]) -> None:
    known = [name for name in names if name not in SET_BY_IDENTIFY]
    for option in method.options:
        if option not in known:
            raise unknown_name(f"{method.name} option", option, known or ["none"])
