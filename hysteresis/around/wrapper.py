"""`Wrapper`, the base class of models that are built around another model."""

import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, ClassVar

from ...arrays import Array
from ..protocol import HysteresisModel, State


@dataclass(frozen=True, kw_only=True)
class Wrapper(HysteresisModel):
    """A model around an inner model, whose kernels, parameters and memory it uses.

    Attributes:
        model: Inner model.
    """

    c_state: ClassVar[int] = 0
    """How many numbers the class adds to the state in C."""

    model: HysteresisModel

    @property
    def kernels(self) -> ModuleType:  # type: ignore[override]
        """Kernels of the inner model."""
        return self.model.kernels

    @cached_property
    def parameter_vector(self) -> Array:
        """Parameters of the inner model, as its kernels read them."""
        return self.model.parameter_vector

    @property
    def memory_size(self) -> int:
        """How many numbers the memory holds, which is that of the inner model."""
        return self.model.memory_size

    @property
    def c_source(self) -> Path:
        """File with what this class adds to the inner model in C99, beside the class."""
        return Path(str(sys.modules[type(self).__module__].__file__)).with_suffix(".c")

    def carry_over(self, memory: Array, parameters: Array) -> Array:
        """Returns the memory in place of another model's; see `HysteresisModel.carry_over`."""
        return self.model.carry_over(memory, parameters)

    def anhysteretic(self, state: State) -> float | None:
        """Returns the torque [N·m] that the inner model relaxes to; see `HysteresisModel`."""
        return self.model.anhysteretic(state)

    def to_dict(self) -> dict[str, Any]:
        """Returns name and inner model, ready for JSON; a subclass adds its own parameters."""
        return {"model": self.name, "hysteresis": self.model.to_dict()}
