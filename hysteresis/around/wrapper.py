"""What the models that are built around another one share."""

from dataclasses import dataclass
from functools import cached_property
from types import ModuleType
from typing import Any

from ...arrays import Array
from ..protocol import HysteresisModel, State


@dataclass(frozen=True, kw_only=True)
class Wrapper(HysteresisModel):
    """A model around another one, which lends it kernels, parameters and memory.

    Attributes:
        model: the model inside.
    """

    model: HysteresisModel

    @property
    def kernels(self) -> ModuleType:  # type: ignore[override]
        """The kernels of the model inside."""
        return self.model.kernels

    @cached_property
    def parameter_vector(self) -> Array:
        """The parameters of the model inside."""
        return self.model.parameter_vector

    @property
    def memory_size(self) -> int:
        """The memory is that of the model inside."""
        return self.model.memory_size

    def anhysteretic(self, state: State) -> float | None:
        """Returns the torque [N·m] that the model inside relaxes to; see `HysteresisModel`."""
        return self.model.anhysteretic(state)

    def to_dict(self) -> dict[str, Any]:
        """Returns name and inner model, ready for JSON; a subclass adds its own parameters."""
        return {"model": self.name, "hysteresis": self.model.to_dict()}
