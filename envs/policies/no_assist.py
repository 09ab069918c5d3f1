"""No assist: the motors give no torque."""

import numpy as np

from ...arrays import Array
from .base import Seen, TorquePolicy


class NoAssist(TorquePolicy):
    """Gives no torque: the wearer alone works against suit, weight and motor friction.

    Args:
        plant: What the policy may know of the arms.
    """

    def torque(self, seen: Seen) -> Array:
        """Returns zeros."""
        return np.zeros((len(seen["angle"]), len(self.peak)))
