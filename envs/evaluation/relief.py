"""Relief: the share of the suit's cost that a policy gives back to its wearer.

Relief 0 is the suit without exoskeleton, 1 is no suit; above 1 the motors carry the person too, and
below 0 the exoskeleton is worse than none.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from .statistics import Interval, ratio_interval

LEAST_COST = 0.01  # [share of strength], least cost of a suit for which relief has a meaning


def relief(
    unsuited: ArrayLike, suited: ArrayLike, effort: ArrayLike, *, least: float = LEAST_COST
) -> Array | None:
    """Returns the relief of each motion, shape (n,); None where the suit costs less than `least`.

    Relief is (suited - effort) over the mean cost of the suit in these motions, so that motions in
    which the suit costs nothing have no infinite relief.

    Args:
        unsuited: Effort of each motion without suit and exoskeleton, shape (motions,).
        suited: Effort in the suit without exoskeleton, shape (motions,).
        effort: Effort under the policy in the first n of these motions, shape (n,).
        least: Least cost of the suit, by default 1 % of strength, which is for effort only.
    """
    unsuited, suited, effort = (np.asarray(one, float) for one in (unsuited, suited, effort))
    cost = suited - unsuited
    if not least <= cost.mean() < np.inf:  # a reference that failed has infinite effort
        return None
    return (suited[: effort.size] - effort) / cost[: effort.size].mean()


def relief_interval(
    unsuited: ArrayLike,
    suited: ArrayLike,
    effort: ArrayLike,
    *,
    least: float = LEAST_COST,
    motion: Sequence[int] = (),
) -> Interval | None:
    """Returns the mean of `relief` with the 95 % interval of a ratio of means; or None.

    Equal numbers in `motion` are of the same motion, as in `statistics.interval_of`.
    """
    if relief(unsuited, suited, effort, least=least) is None:
        return None
    series = np.subtract(suited, effort), np.subtract(suited, unsuited)
    return ratio_interval(*series, motion=motion)
