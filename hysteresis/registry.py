"""The models by name, and their way back from plain dictionaries."""

from collections.abc import Mapping
from typing import Any

from ..errors import InputError, unknown_name
from .around.asymmetric import Asymmetric
from .around.held import Held
from .around.wrapper import Wrapper
from .bouc_wen.model import BoucWen
from .jiles_atherton.model import JilesAtherton
from .prandtl_ishlinskii.model import PrandtlIshlinskii
from .preisach.model import Preisach
from .protocol import HysteresisModel

MODELS: dict[str, type[HysteresisModel]] = {
    model.name: model
    for model in (JilesAtherton, BoucWen, Preisach, PrandtlIshlinskii, Asymmetric, Held)
}


def model_from_dict(content: Mapping[str, Any]) -> HysteresisModel:
    """Returns the model that `to_dict` described.

    Raises:
        InputError: no or an unknown name, or unknown, missing or bad parameters.
    """
    if not isinstance(content, Mapping):
        raise InputError(f"a model is described by a dictionary, not by {content!r}")
    parameters = dict(content)
    name = parameters.pop("model", None)
    if not isinstance(name, str) or name not in MODELS:
        raise unknown_name("model", str(name), MODELS)
    if issubclass(MODELS[name], Wrapper) and "hysteresis" in parameters:
        parameters["model"] = model_from_dict(parameters.pop("hysteresis"))
    try:
        return MODELS[name](**parameters)
    except TypeError as error:
        raise InputError(f"model {name!r}: {str(error).split('__init__() ')[-1]}") from error
