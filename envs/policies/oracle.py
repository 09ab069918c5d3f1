"""The oracle: the motors cancel the true suit torque, which no real device can measure."""

from ...arrays import Array
from .base import Seen, TorquePolicy


class Oracle(TorquePolicy):
    """Cancels the true suit torque of this moment; only the delay of the motors remains.

    Args:
        plant: What the policy may know of the arms.
    """

    sensors = ("encoders", "privileged")

    def torque(self, seen: Seen) -> Array:
        """Returns minus the suit torque [N·m], shape (n, 2)."""
        return -seen["suit_torque"][:, self.assisted]
