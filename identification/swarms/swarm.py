"""The particle swarm that all variants share: a caller asks for positions, and tells values."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import OptimizeResult

from ...arrays import Array
from ...errors import InputError

Objective = Callable[[Array], ArrayLike]
Callback = Callable[[OptimizeResult], None]
Bounds = Sequence[tuple[float, float]]
FARTHEST = 1e300  # largest bound, so that no difference of positions overflows


class Swarm(ABC):
    """Particles with velocities and personal bests, scattered by eq. (5), (6) of Li et al. 2022.

    A caller asks for positions, evaluates them and tells the values, until `stopped` names a reason
    to end; `minimize` is that loop. The first round evaluates the scattered particles; every later
    round moves the particles first:

    - velocity: eq. (8), each component then set back into +-`velocity_limit` times the range;
    - position: eq. (9), each component then set back to its bound; the velocity stays as it is.

    Values that are not finite count as infinitely bad. The result is the best point ever evaluated,
    whatever particle the swarm was following. A swarm can be pickled at any moment, also between
    ask and tell; the unpickled swarm continues with the same numbers bit for bit.

    Args:
        bounds: One pair (low, high) per parameter.
        swarm_size: Number of particles.
        max_iterations: Number of moves after the first evaluation.
        velocity_limit: Largest move per iteration, as a fraction of each parameter's range; a
            faster component is set back to this limit. Both papers leave Vmax open.
        target: The run ends as soon as the best value is below the target (steps 4 and 11 of Li et
            al. 2022 use 1e-3); None sets no target.
        rng: Seed or generator; the same seed gives the same result bit for bit.
    """

    def __init__(
        self,
        bounds: Bounds,
        *,
        swarm_size: int = 50,
        max_iterations: int = 100,
        velocity_limit: float = 0.2,
        target: float | None = None,
        rng: int | np.random.Generator | None = None,
    ) -> None:
        self._low, self._high = low, high = checked_bounds(bounds)
        if not (swarm_size >= 2 and max_iterations >= 1 and 0 < velocity_limit <= 1):
            raise InputError(
                f"swarm_size is {swarm_size}, max_iterations {max_iterations}, velocity_limit "
                f"{velocity_limit}: use at least 2, at least 1, and a fraction in (0, 1]"
            )
        self._max_iterations, self._target = max_iterations, target
        self._rng = np.random.default_rng(rng)
        self._fastest = limit = velocity_limit * (high - low)
        self._slowest = -limit
        shape = (swarm_size, low.size)
        self._position: Array = self._rng.random(shape) * (high - low) + low
        self._velocity: Array = self._rng.random(shape) * 2 * limit - limit
        self._personal: Array = self._position.copy()
        self._personal_fitness: Array = np.full(swarm_size, np.inf)
        self._draws = (2, swarm_size, 1)
        self._history: list[float] = []
        self._discarded = 0
        self._asked = False

    @property
    def iteration(self) -> int:
        """Finished moves, not counting the first evaluation."""
        return max(len(self._history) - 1, 0)

    @property
    def stopped(self) -> str:
        """Reason why the run has ended, in words; empty as long as the run continues."""
        if not self._history:
            return ""
        if self._target is not None and self._history[-1] < self._target:
            return f"reached the target {self._target:g}"
        return "ran all iterations" if self.iteration >= self._max_iterations else ""

    @property
    def result(self) -> OptimizeResult:
        """The result so far; `minimized` lists its fields.

        Raises:
            InputError: `tell` has not received any values yet.
        """
        if not self._history:
            raise InputError("there is no result before the first tell: ask, evaluate, then tell")
        best = int(self._personal_fitness.argmin())
        return OptimizeResult(
            x=self._personal[best].copy(),
            fun=float(self._personal_fitness[best]),
            nit=self.iteration,
            nfev=len(self._position) * len(self._history),
            history=np.array(self._history),
            discarded=self._discarded,
            population=self._position.copy(),
            success=bool(self.stopped),
            message=self.stopped or "not finished",
        )

    def ask(self) -> Array:
        """Returns the positions to evaluate, (n, d), the same ones until `tell` is called."""
        if not self._asked:
            if self.stopped:
                raise InputError(f"ask after the end ({self.stopped}): read result, or start anew")
            if self._history:
                self._move()
            self._asked = True
        return self._position.copy()

    def tell(self, fitness: ArrayLike) -> None:
        """Takes the values, (n,), of the positions that `ask` returned.

        Raises:
            InputError: `ask` was not called before; the shape is wrong; or it is the first round
                and no value is finite.
        """
        if not self._asked:
            raise InputError("tell was called before ask: ask for positions, evaluate, then tell")
        scores = finite_scores(fitness, self._position.shape)
        finite = int(np.count_nonzero(scores < np.inf))
        if not finite and not self._history:
            raise InputError(
                f"the objective has no finite value at any of the {scores.size} first particles: "
                "check the bounds and the data"
            )
        self._discarded += scores.size - finite
        self._take(scores)
        self._history.append(float(self._personal_fitness.min()))
        self._asked = False

    def minimize(self, objective: Objective, callback: Callback | None = None) -> OptimizeResult:
        """Asks and tells until the run ends; see `minimized`. A swarm may have run before."""
        while not self.stopped:
            self.tell(objective(self.ask()))
            if callback is not None and self.iteration:
                try:
                    callback(self.result)
                except StopIteration:
                    return OptimizeResult(
                        self.result, success=False, message="stopped by the callback"
                    )
        return self.result

    @abstractmethod
    def _coefficients(self) -> tuple[float, float, float]:
        """Inertia, cognitive and social coefficient of the coming move."""

    def _leader(self) -> int:
        """The particle whose personal best the others follow."""
        return int(self._personal_fitness.argmin())

    def _move(self) -> None:
        """Moves every particle once, by eq. (8) and (9)."""
        leader = self._personal[self._leader()]
        inertia, cognitive, social = self._coefficients()
        own, others = self._rng.random(self._draws)
        velocity = (
            inertia * self._velocity
            + cognitive * own * (self._personal - self._position)
            + social * others * (leader - self._position)
        )
        self._velocity = np.clip(velocity, self._slowest, self._fastest)
        self._position = np.clip(self._position + self._velocity, self._low, self._high)

    def _take(self, fitness: Array) -> None:
        """Updates the personal bests by the values (n,) of the present positions."""
        better = fitness < self._personal_fitness
        np.copyto(self._personal, self._position, where=better[:, np.newaxis])
        np.copyto(self._personal_fitness, fitness, where=better)


def checked_bounds(bounds: Bounds) -> tuple[Array, Array]:
    """Returns the lower and upper bounds, shape (d,) each."""
    pairs = np.array(bounds, dtype=np.float64)
    if pairs.ndim != 2 or pairs.shape[1] != 2 or pairs.size == 0:
        raise InputError(
            f"bounds have shape {pairs.shape}: give one pair (low, high) per parameter"
        )
    for index, (low, high) in enumerate(pairs):
        if not (low < high and abs(low) < FARTHEST and abs(high) < FARTHEST):
            raise InputError(
                f"bounds[{index}] are ({low:g}, {high:g}): give finite numbers with low < high, "
                f"less than {FARTHEST:g} from 0"
            )
    return pairs[:, 0].copy(), pairs[:, 1].copy()


def finite_scores(fitness: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Returns the values (n,) of positions of shape (n, d), infinite where they are not finite."""
    values = np.asarray(fitness, dtype=np.float64)
    if values.shape != shape[:1]:
        raise InputError(
            f"the objective returned shape {values.shape} for positions of shape {shape}: it must "
            f"map (n, d) to (n,), here ({shape[0]},)"
        )
    return np.where(np.isfinite(values), values, np.inf)
