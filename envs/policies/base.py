"""The protocol of a policy."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class Policy(Protocol):
    """A controller of the motors; its memory, if it has any, lasts from `reset` to `reset`.

    `reset()` is called after the environment's reset, then `act(observation, info)` once per
    control period with what the environment returned last; it returns the next action.
    """

    def reset(self) -> None:
        """Clears the memory of the last episode."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the next action, in [-1, 1] for each assisted joint."""
        ...
