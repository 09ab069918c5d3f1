"""A plan: commands that were worked out before the motion, for bounds."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ...arrays import Array


class Planned:
    """Gives the commands of a plan, one after the other, whatever it observes.

    Args:
        commands: Torque of the motors over their peaks, shape (rows, periods, 2).
    """

    sensors: ClassVar[tuple[str, ...]] = ("encoders",)

    def __init__(self, commands: Array) -> None:
        self.commands, self._period = commands, 0

    def reset(self) -> None:
        """Goes back to the first command."""
        self._period = 0

    def act(self, observation: NDArray[np.float32]) -> NDArray[np.float64]:
        """Returns the next command of each row; the last one stays."""
        command = self.commands[:, min(self._period, self.commands.shape[1] - 1)]
        self._period += 1
        return command.reshape(*observation.shape[:-1], -1)
