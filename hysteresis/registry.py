"""The registry of hysteresis models: name -> class, and the way back from plain dictionaries."""

import inspect
from collections.abc import Mapping
from types import ModuleType
from typing import Any

from ..errors import InputError, shown, unknown_name
from .around import Asymmetric, Backlash, Clipped, Viscoelastic, Wrapper
from .bouc_wen import BoucWen
from .dahl import Dahl, Duhem
from .jiles_atherton import JilesAtherton
from .preisach import Preisach
from .protocol import HysteresisModel
from .stops import HingedStops, PrandtlIshlinskii

MODELS: dict[str, type[HysteresisModel]] = {
    model.name: model
    for model in (
        JilesAtherton,
        BoucWen,
        Preisach,
        PrandtlIshlinskii,
        HingedStops,
        Dahl,
        Duhem,
        Asymmetric,
        Clipped,
        Backlash,
        Viscoelastic,
    )
}


KERNELS = ("memory_size begin move commit stiffness stored dissipated is_sound").split()
"""Names that a module of kernels must define; see `HysteresisModel`."""
OLD_NAMES = {"held": Clipped.name}
"""Names of models in files of version 0.2, with the present names."""


def register_model(model: type[HysteresisModel]) -> None:
    """Registers a class of models for dictionaries, suit files, the engine and the command line.

    The class is derived from `HysteresisModel`, with a name of its own and all kernels.
    """
    if not (isinstance(model, type) and issubclass(model, HysteresisModel)):
        raise InputError(f"model is {model!r}: give a class derived from HysteresisModel")
    missing = sorted(getattr(model, "__abstractmethods__", ()))
    missing += [name for name in ("name", "kernels") if not hasattr(model, name)]
    kernels = getattr(model, "kernels", None)
    if isinstance(kernels, ModuleType):
        missing += [f"kernels.{one}" for one in KERNELS if not hasattr(kernels, one)]
    if missing:
        raise InputError(f"model {model.__name__} lacks {', '.join(missing)}: define that")
    if MODELS.get(model.name, model) is not model:
        raise InputError(f"there is another model {model.name!r}: choose another name")
    MODELS[model.name] = model


def model_from_dict(content: Mapping[str, Any]) -> HysteresisModel:
    """Returns the model of a dictionary as `to_dict` makes it."""
    if not isinstance(content, Mapping):
        raise InputError(f"a model is described by a dictionary, not by {shown(content)}")
    parameters = dict(content)
    name = str(parameters.pop("model", None))
    name = OLD_NAMES.get(name, name)
    if name not in MODELS:
        raise unknown_name("model", name, MODELS)
    if issubclass(MODELS[name], Wrapper):
        if "hysteresis" not in parameters:
            raise InputError(
                f"model {name!r} has no 'hysteresis': give the model inside it, as a "
                "dictionary of its own"
            )
        parameters["model"] = model_from_dict(parameters.pop("hysteresis"))
    known = inspect.signature(MODELS[name]).parameters
    for given in parameters:
        if given not in known:
            raise unknown_name(f"parameter of {name!r}", given, known)
    missing = [one.name for one in known.values() if one.default is one.empty]
    missing = [one for one in missing if one not in parameters]
    if missing:
        raise InputError(f"model {name!r} has no {', '.join(missing)}: give a value of each")
    return MODELS[name](**parameters)
