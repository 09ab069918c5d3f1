"""Impedance: springs and dampers pull the arm along the intention that the preview tells."""

import math

from ...arrays import Array
from ...checks import within
from ..belief import Belief
from ..plant import Plant
from ..simulation.state import PREVIEW
from .base import Seen
from .model_based import Compensation


class Impedance(Compensation):
    """Pulls the arm along the intention by springs and dampers, beside compensation.

    Law: compensation + K (q_d - q) + B (q_d' - q'), all at the angles of soon.
    Tuning rule: K = M w² and B = 2 z M w with the believed inertia M of each joint, the bandwidth
    w and the damping ratio z; w is a fifth of the inverse of the loop's lag, 0.03 s.
    Signals needed: encoders and a preview of the intention. Where the preview is wrong it fights
    the wearer.
    Source: Hogan 1985, Impedance control, J. Dyn. Syst. Meas. Control 107, 1-24.

    Args:
        plant: What the policy may know of the arms.
        belief: What the controller believes of person, suit and load.
        bandwidth: Natural frequency of the believed arm on the springs [Hz], 0 to 3.
        damping_ratio: Damping ratio, 0 to 3.
    """

    sensors = ("encoders", "preview")

    def __init__(
        self,
        plant: Plant,
        belief: Belief | None = None,
        *,
        bandwidth: float = 1.0,
        damping_ratio: float = 1.0,
    ) -> None:
        super().__init__(plant, belief)
        within("bandwidth", bandwidth, 0, 3, " Hz")
        within("damping_ratio", damping_ratio, 0, 3)
        inertia, pole = plant.believed(belief).inertia().nominal(), math.tau * bandwidth
        self.stiffness, self.damping = inertia * pole**2, 2 * damping_ratio * inertia * pole

    def torque(self, seen: Seen) -> Array:
        """Returns compensation and the pull of springs and dampers [N·m], shape (n, 2)."""
        angle, rate = seen["angle"][:, self.assisted], seen["rate"][:, self.assisted]
        target, target_rate = intended(seen["target"])
        pull = self.stiffness * (target - angle - self.lead * rate)
        return super().torque(seen) + pull + self.damping * (target_rate - rate)


def intended(target: Array) -> tuple[Array, Array]:
    """Returns angle [rad] and rate [rad/s] that are intended soon, shape (n, 2) each.

    Soon is at the nearest previewed time, when the motors have answered. The rate there is that of
    the parabola through the three previewed angles.

    Args:
        target: Previewed angles [rad], the nearest first, shape (n, 6).
    """
    now, next_, last = target[:, 0:2], target[:, 2:4], target[:, 4:6]
    near, far = PREVIEW[1] - PREVIEW[0], PREVIEW[2] - PREVIEW[0]
    first, second = (next_ - now) / near, (last - now) / far
    return now, (far * first - near * second) / (far - near)
