"""What the preview tells of the intended motion of shoulder and elbow."""

from ...arrays import Array
from ..simulation.simulation import PREVIEW


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
