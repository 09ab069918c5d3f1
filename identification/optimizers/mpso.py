"""MPSO: the swarm with scheduled learning factors (Li et al. 2022, section 5.1)."""

import math
from typing import Unpack

from scipy.optimize import OptimizeResult

from .pso import LINEAR_RANGE, linear_inertia
from .swarm import Bounds, Callback, Objective, Swarm, SwarmOptions

COGNITIVE_FIRST, COGNITIVE_LAST = 2.5, 1.3
SOCIAL_FIRST, SOCIAL_LAST = 0.5, 1.7


def scheduled_coefficients(iteration: int, iterations: int) -> tuple[float, float, float]:
    """Linear inertia, eq. (13), and learning factors, eq. (14).

    The "A" of eq. (14) is read as the inertia Lambda(n) of eq. (13): only then do its limits mean
    anything, and c1, c2 run from (2.5, 0.5) to exactly (1.3, 1.7).
    """
    first, last = LINEAR_RANGE
    inertia = linear_inertia(iteration, iterations)
    relative = (inertia - last) / (first - last)
    share = math.exp(-70 * relative**6)
    cognitive = COGNITIVE_FIRST - (COGNITIVE_FIRST - COGNITIVE_LAST) * share
    social = SOCIAL_FIRST - (SOCIAL_FIRST - SOCIAL_LAST) * share
    return inertia, cognitive, social


class MPSO(Swarm):
    """MPSO as an ask/tell core; arguments and errors are those of `Swarm`."""

    def _coefficients(self) -> tuple[float, float, float]:
        return scheduled_coefficients(self.iteration, self._max_iterations)


def mpso(
    objective: Objective,
    bounds: Bounds,
    *,
    callback: Callback | None = None,
    **common: Unpack[SwarmOptions],
) -> OptimizeResult:
    """Minimizes with MPSO: eq. (13) and (14) of Li et al. 2022 on the basic swarm.

    Arguments, result and errors are those of `pso`, without its coefficients. `MPSO` is the same as
    an ask/tell core that can be saved and resumed.
    """
    return MPSO(bounds, **common).minimize(objective, callback)
