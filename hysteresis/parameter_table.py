"""The table of the parameters of hysteresis models."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..tables import Rows
from . import HysteresisModel, JilesAtherton, Viscoelastic
from .around import Wrapper

FEW = 6  # numbers that a cell lists


def parameter_table(models: Mapping[str, HysteresisModel]) -> Rows:
    """Returns one column per model and one row per parameter; Jiles-Atherton has degrees."""
    columns = [{"model": _kind(model), **_parameters(model)} for model in models.values()]
    names = dict.fromkeys(name for column in columns for name in column)
    rows = [[name, *(column.get(name, "-") for column in columns)] for name in names]
    return ["", *models], rows


def _kind(model: HysteresisModel) -> str:
    name = model.name.replace("-", "-\n")
    return f"{name}\n{_kind(model.model)}" if isinstance(model, Wrapper) else name


def _parameters(model: HysteresisModel) -> dict[str, str]:
    """Returns the parameters of a model as text, by name and unit; many numbers by their range."""
    inner = _parameters(model.model) if isinstance(model, Wrapper) else {}
    if isinstance(model, JilesAtherton):
        model = model.in_unit("deg")
    own = {
        labeled(name, model.units): _text(value)
        for name, value in model.to_dict().items()
        if name not in ("model", "hysteresis", "angle_unit")
        and not (isinstance(model, Viscoelastic) and value == 0)  # an element that is not there
    }
    return inner | own


def labeled(name: str, units: Mapping[str, str]) -> str:
    """Returns the name of a parameter with the unit, or alone for a pure number."""
    shown = "offset of the model" if name == "offset" else name  # not that of a torque sensor
    return f"{shown} [{units[name]}]" if name in units else shown


def _text(value: Any) -> str:
    if isinstance(value, (bool, str)):
        return str(value)
    numbers = np.concatenate([np.atleast_1d(row) for row in np.atleast_1d(np.array(value, object))])
    if numbers.size > FEW:
        return f"{numbers.size} numbers,\n{numbers.min():.4g} to {numbers.max():.4g}"
    return "\n".join(f"{number:.5g}" for number in numbers)
