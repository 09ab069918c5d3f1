"""The certified fits by the name of their model, and the registration of fits from outside.

A fit is a function `fit(curves, **options)` of the measured curves. It takes a random generator as
the option `rng` if it depends on random numbers, and returns a model that is certified and
dissipative, at least with constant torque outside the angles of the curves; or a `FitResult`, which
has more.
"""

import inspect
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol

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
from .objective import InitialTorque, nrmse, torque_errors
from .weights import fit_hinged_stops, fit_prandtl_ishlinskii, fit_preisach

QUICK = 600  # evaluations of a fit that only compares gaps or rounds


class FitResult(Protocol):
    """A model, with further results of its fit."""

    @property
    def model(self) -> HysteresisModel:
        """The certified model."""
        ...

    @property
    def initial_torque(self) -> InitialTorque:
        """The torque with which all curves begin [N·m]; or "measured"."""
        ...

    @property
    def nrmse(self) -> float:
        """The error on the curves that the fit minimized."""
        ...

    @property
    def evaluations(self) -> int | None:
        """How often the model ran on all curves; None if the fit does not count."""
        ...


FitFunction = Callable[..., HysteresisModel | FitResult]
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


class Fitted(NamedTuple):
    """Result of a certified fit.

    Attributes:
        model: A certified and dissipative model, at least with constant torque outside the angles
            of the curves.
        initial_torque: The torque with which all curves begin [N·m]; or "measured": each begins
            with its first sample.
        loss: The NRMSE on the curves; for Jiles-Atherton with their weights.
        evaluations: How often the model ran on all curves; None where the fit does not count.
        agreed: How many runs from different starts ended here; None where the fit has one start.
        starts: How many runs there were; None likewise.
    """

    model: HysteresisModel
    initial_torque: InitialTorque
    loss: float
    evaluations: int | None = None
    agreed: int | None = None
    starts: int | None = None


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
    if rate != "none" or play != "none":
        if rate != "none":
            fit = partial(fit_model, name, rng=rng, play=play, **options)
            model, start = fit_beside_rate(curves, rate, fit, partial(fit, **less))
        else:
            fit = partial(fit_model, name, rng=rng, **options)
            model, start = fit_behind_play(curves, fit, partial(fit, **less))
        return Fitted(model, start, nrmse(torque_errors(model, start, curves), curves))
    if is_seeded(name):
        options["rng"] = rng
    found = FITS[name](curves, **options)
    if isinstance(found, HysteresisModel):
        start = common_torque(found, curves)
        return Fitted(found, start, nrmse(torque_errors(found, start, curves), curves))
    return Fitted(
        found.model,
        found.initial_torque,
        found.nrmse,
        found.evaluations,
        getattr(found, "agreed", None),
        getattr(found, "starts", None),
    )


def is_seeded(name: str) -> bool:
    """Returns whether the fit of a model depends on random numbers."""
    return "rng" in inspect.signature(FITS[name]).parameters
