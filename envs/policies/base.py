"""The protocol of a policy."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..episodes import Episodes


class Arms(Protocol):
    """An environment that policies are made for: `ArmEnv` or `ArmVectorEnv`."""

    episodes: Episodes


class Policy(Protocol):
    """A controller of the motors, for one arm or for rows of arms at once.

    `reset()` is called after the environment's reset, then `act(observation)` once per control
    period. The observation is all that a policy learns of the simulation. Its memory, if it has
    any, lasts from `reset` to `reset`, and is of as many arms as it saw first.

    Shipped policies name the sensor suites that they need in `sensors`.
    """

    def reset(self) -> None:
        """Clears the memory of the last episode."""

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the next action, in [-1, 1] for each assisted joint.

        Args:
            observation: Observation of one arm, shape (size,), or of rows, shape (..., size).

        Returns:
            The action, shape (..., motors).
        """
        ...
