"""Relief: the share of the suit's cost that a policy gives back to its wearer.

0 is no better than leaving the exoskeleton at home, 1 moves as without a suit, more carries the
person, and less than 0 is worse than no exoskeleton.
"""

import numpy as np
from numpy.typing import ArrayLike

from ...arrays import Array
from .statistics import Interval, ratio_interval

LEAST_COST = 0.01  # share of strength that a suit must cost for relief to have a meaning


def relief(
    unsuited: ArrayLike, suited: ArrayLike, effort: ArrayLike, *, least: float = LEAST_COST
) -> Array | None:
    """Returns the relief of each motion, shape (n,); None where the suit costs less than `least`.

    It is (E suited - E) over the mean cost of the suit in these motions, so that a motion in which
    the suit costs nothing does not decide.

    Args:
        unsuited: Effort of each motion without suit and exoskeleton, shape (motions,).
        suited: Effort in the suit without exoskeleton, shape (motions,).
        effort: Effort under the policy in the first of these motions, shape (n,).
        least: Cost of the suit for relief to have a meaning, by default 1 % of strength. Other
            costs of the wearer than effort have another one.
    """
    unsuited, suited, effort = (np.asarray(one, float) for one in (unsuited, suited, effort))
    cost = suited - unsuited
    if not least <= cost.mean() < np.inf:  # a reference that failed has infinite effort
        return None
    return (suited[: effort.size] - effort) / cost[: effort.size].mean()


def relief_interval(
    unsuited: ArrayLike, suited: ArrayLike, effort: ArrayLike, *, least: float = LEAST_COST
) -> Interval | None:
    """Returns the mean of `relief` with its 95 % interval, that of a ratio of means; or None."""
    if relief(unsuited, suited, effort, least=least) is None:
        return None
    return ratio_interval(np.subtract(suited, effort), np.subtract(suited, unsuited))
