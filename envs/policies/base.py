"""The protocol of a policy."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


class Policy(Protocol):
    """Anything that assists: its memory, if any, lasts from `reset` to `reset`.

    `reset()` is called after the environment's reset, then `act(observation, info)` once per
    control period with what the environment returned last; it answers with the next action.
    """

    def reset(self) -> None:
        """Forgets the last episode."""

    def act(self, observation: NDArray[np.float32], info: dict[str, Any]) -> NDArray[np.float64]:
        """Returns the action in [-1, 1] per assisted joint for what `reset` or `step` returned."""
        ...
