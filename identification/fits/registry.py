"""The certified fits by the name of their model, and the registration of fits from outside.

A fit is a function `fit(curves, **options)` of the measured curves. It takes a random generator as
the option `rng` if it depends on random numbers, and returns a model that is certified and
dissipative, at least with constant torque outside the angles of the curves; or a result that has
this `model`, and `initial_torque` [N·m], `nrmse` and `evaluations` as `Fitted` describes them.
"""

import inspect
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from ...errors import InputError
from ...hysteresis.around.asymmetric import Asymmetric
from ...hysteresis.bouc_wen.model import BoucWen
from ...hysteresis.dahl.model import Dahl, Duhem
from ...hysteresis.hinged_stops.model import HingedStops
from ...hysteresis.jiles_atherton.model import JilesAtherton
from ...hysteresis.prandtl_ishlinskii.model import PrandtlIshlinskii
from ...hysteresis.preisach.model import Preisach
from ...hysteresis.protocol import HysteresisModel
from ..data.curves import Curve
from .beside import Play, Rate, fit_behind_play, fit_beside_rate
from .beside_polynomial import fit_asymmetric, fit_bouc_wen, fit_dahl, fit_duhem
from .certified import certified_fit, common_torque
from .objective import Fitted, scored
from .weights import fit_hinged_stops, fit_prandtl_ishlinskii, fit_preisach

QUICK = 600  # evaluations of a fit that only compares gaps or rounds


FitFunction = Callable[..., Any]
FITS: dict[str, FitFunction] = {
    JilesAtherton.name: certified_fit,
    Asymmetric.name: fit_asymmetric,
    BoucWen.name: fit_bouc_wen,
    PrandtlIshlinskii.name: fit_prandtl_ishlinskii,
    Preisach.name: fit_preisach,
    HingedStops.name: fit_hinged_stops,
    Dahl.name: fit_dahl,
    Duhem.name: fit_duhem,
}


def register_fit(model_name: str, fit: FitFunction) -> None:
    """Makes a fit known to `identify`, for a hysteresis model from outside the package.

    From then on `identify(curves, model=model_name)` uses it, and `select` tries it.

    Args:
        model_name: The `name` of the model.
        fit: A function as this module describes it.
    """
    if not callable(fit):
        raise InputError(f"fit of {model_name!r} is {fit!r}: give a function of the curves")
    if FITS.setdefault(model_name, fit) is not fit:
        raise InputError(f"model {model_name!r} has a fit already: choose another name")


def fit_model(
    name: str,
    curves: Sequence[Curve],
    rng: np.random.Generator,
    *,
    rate: Rate = "none",
    play: Play = "none",
    **options: Any,
) -> Fitted:
    """Fits the model `name` of `FITS` to curves.

    A fit that returns a bare model has the torque at the beginning identified here.

    Args:
        name: The name of the model.
        curves: The measured curves.
        rng: The generator that a seeded fit uses.
        rate: Elements that are fitted beside it: none ("none"), a dashpot ("viscous"), or a Maxwell
            element too ("relaxing").
        play: Whether a gap before it is fitted too ("fit"), or there is none ("none").
        **options: The options of the fit.
    """
    takes = inspect.signature(FITS[name]).parameters
    less = {"budget": min(QUICK, options.get("budget", QUICK))} if "budget" in takes else {}
    if rate != "none":
        fit = partial(fit_model, name, rng=rng, play=play, **options)
        return fit_beside_rate(curves, rate, fit, partial(fit, **less))
    if play != "none":
        fit = partial(fit_model, name, rng=rng, **options)
        return fit_behind_play(curves, fit, partial(fit, **less))
    if "rng" in takes:
        options["rng"] = rng
    found = FITS[name](curves, **options)
    if isinstance(found, HysteresisModel):
        return scored(found, common_torque(found, curves), curves)
    starts = {name: getattr(found, name, None) for name in ("agreed", "starts")}
    return Fitted(found.model, found.initial_torque, found.nrmse, found.evaluations, **starts)


def is_seeded(name: str) -> bool:
    """Returns whether the fit of a model depends on random numbers."""
    return "rng" in inspect.signature(FITS[name]).parameters
