"""The methods of `identify`, and the checks of their options."""

import inspect
from typing import Any, get_args

from ..checks import at_least
from ..errors import InputError, unknown_name
from ..hysteresis.jiles_atherton.model import JilesAtherton
from .fits.play import Play
from .fits.rate import Rate
from .fits.registry import FITS, is_seeded
from .objective import InitialTorque
from .optimizers.registry import OPTIMIZERS, SWARMS
from .optimizers.swarm import SwarmOptions
from .softening import Softens

METHODS = ("certified", "auto", *OPTIMIZERS)
DEFAULT_MODEL = JilesAtherton.name  # the only model that every method can identify
SET_BY_IDENTIFY = ("curves", "objective", "bounds", "rng", "callback", "initial_torque")


def check_method(model: str | None, method: str) -> None:
    """Refuses unknown names, and methods that a model does not have.

    Raises:
        InputError: The model or the method is unknown, or they do not go together.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    if model is None:
        return
    if model not in FITS:
        raise unknown_name("model", model, FITS)
    if method == "auto":
        raise InputError(f"model is {model!r}, but method 'auto' chooses the model: leave one out")
    if method != "certified" and model != DEFAULT_MODEL:
        raise InputError(f"method is {method!r}: model {model!r} has the method 'certified' only")


def check_options(
    model: str | None,
    method: str,
    objective: str | None,
    normalize: str | None,
    initial_torque: InitialTorque | None,
    trials: int | None,
    rate: Rate,
    play: Play,
    options: dict[str, Any],
) -> None:
    """Refuses options that the method would ignore; None stands for one that is left out.

    Raises:
        InputError: An option is unknown, or the method would ignore it.
    """
    for option, given in (("objective", objective), ("normalize", normalize)):
        if given is not None and method not in OPTIMIZERS:
            raise InputError(
                f"{option} is {given!r}: method {method!r} always minimizes the NRMSE over the "
                "family; leave it out, or use a swarm or a baseline"
            )
    for option, given, known in (("rate", rate, Rate), ("play", play, Play)):
        if given not in get_args(known):
            raise unknown_name(option, given, get_args(known))
        if given != "none" and method in OPTIMIZERS:
            raise InputError(
                f"{option} is {given!r}, which the method {method!r} does not fit: use the method "
                f"'certified' or 'auto', or {option} 'none'"
            )
    name = model or DEFAULT_MODEL
    identifies = method == "auto" or name != DEFAULT_MODEL
    if identifies and initial_torque not in (None, "identified"):
        raise InputError(
            f"initial_torque is {initial_torque!r}: the fits of other models than "
            f"{DEFAULT_MODEL!r} identify it; leave it out"
        )
    if trials is not None:
        at_least("trials", trials, 1)
        if trials > 1 and (method == "auto" or not is_seeded(name)):
            what = "method 'auto' chooses" if method == "auto" else f"the fit of {name!r} is made"
            raise InputError(f"trials is {trials}: {what} once; leave it out")
    names = _own_options(name, method)
    for option in options:
        if option not in names:
            raise unknown_name(f"{method} option", option, names or ["none"])


def check_corrections(tare: object, softening: Softens) -> None:
    """Refuses corrections of the curves that are unknown, or not identifiable together.

    Raises:
        InputError: `softening` is unknown, or it and the tare are fitted.
    """
    if softening not in get_args(Softens):
        raise unknown_name("softening", softening, get_args(Softens))
    if softening == "fitted" and tare == "fitted":
        raise InputError(
            "tare and softening are both 'fitted': fit the tare first, and give it as a number"
        )


def _own_options(model: str, method: str) -> list[str]:
    if method == "auto":
        return []
    function = FITS[model] if method == "certified" else OPTIMIZERS[method]
    names = list(inspect.signature(function).parameters)
    if method in SWARMS:
        names[-1:] = SwarmOptions.__annotations__  # names behind **common
    return [name for name in names if name not in SET_BY_IDENTIFY]
