"""The optimizers by name: the papers' swarms, and those that are registered."""

from collections.abc import Callable

from scipy.optimize import OptimizeResult

from ...errors import InputError
from .mpso import mpso
from .pso import pso
from .rank_distance_mpso import rank_distance_mpso
from .sa_pso import sa_pso

Optimizer = Callable[..., OptimizeResult]

SWARMS: dict[str, Optimizer] = {
    "pso": pso,
    "sa-pso": sa_pso,
    "mpso": mpso,
    "rank-distance-mpso": rank_distance_mpso,
}
OPTIMIZERS: dict[str, Optimizer] = dict(SWARMS)
NO_SEARCHES = ("auto", "certified", "magnetic")  # methods of `identify` that no optimizer may hide


def register_optimizer(name: str, minimize: Optimizer) -> None:
    """Makes an optimizer known to `identify`, as a method of `Search` and of the command line.

    It is called as `minimize(objective, bounds, rng=generator, **options)`. The objective maps
    positions (n, d) to values (n,), infinite where there is none, and bounds are d pairs. The
    options are the further arguments of `minimize`. Trials run at once in threads, so that
    `minimize` keeps nothing between calls.

    Args:
        name: Name of the method.
        minimize: Function whose result has `x`, `fun` and `history`, as that of `pso`.
    """
    if not callable(minimize):
        raise InputError(f"optimizer {name!r} is {minimize!r}: give a function that minimizes")
    if name in NO_SEARCHES or OPTIMIZERS.setdefault(name, minimize) is not minimize:
        raise InputError(f"there is another method {name!r}: choose another name")
