"""Rank-distance MPSO: survival by rank of error and rank of distance (Kao and Fung 2009)."""

from typing import ClassVar, Literal, Unpack

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from .pso import KAO_FUNG, PSO, Inertia
from .swarm import Bounds, Callback, Objective, SwarmOptions

DECAY_MAX, DECAY_MIN = 0.7, 0.005  # rho_max, rho_min
REGULATING_SCALE = 1.25  # R

DistanceRank = Literal["far", "near"]


class RankDistanceMPSO(PSO):
    """Rank-distance MPSO as an ask/tell core.

    An individual is a particle with its position, velocity and personal best. `ask` returns the
    offspring; `tell` lets the best-scored half of parents and offspring together survive.

    Args:
        bounds: One pair (low, high) per parameter.
        distance_rank: Individual that has distance rank 1: the farthest, or the nearest.
        patience: Number of iterations in a row without a better value that ends the run, or None.
        inertia: Inertia of the velocity: "tanh", "linear" or a constant.
        cognitive: Coefficient c1, the pull towards a particle's own best.
        social: Coefficient c2, the pull towards the best of all.
        per_dimension: Whether random numbers are drawn for each dimension of each particle.
        **common: Options that every swarm takes; `SwarmOptions` lists them.
    """

    _CHANGING: ClassVar[tuple[str, ...]] = (
        *PSO._CHANGING,
        "_parent_position",
        "_parent_velocity",
        "_fitness",
        "_decay",
        "_unimproved",
    )

    def __init__(
        self,
        bounds: Bounds,
        *,
        distance_rank: DistanceRank = "far",
        patience: int | None = None,
        inertia: Inertia = KAO_FUNG["inertia"],
        cognitive: float = KAO_FUNG["cognitive"],
        social: float = KAO_FUNG["social"],
        per_dimension: bool = KAO_FUNG["per_dimension"],
        **common: Unpack[SwarmOptions],
    ) -> None:
        super().__init__(
            bounds,
            inertia=inertia,
            cognitive=cognitive,
            social=social,
            per_dimension=per_dimension,
            **common,
        )
        if distance_rank not in ("far", "near"):
            raise InputError(f"distance_rank is {distance_rank!r}: use 'far' or 'near'")
        if patience is not None:
            at_least("patience", patience, 1)
        self._options |= {"distance_rank": distance_rank, "patience": patience}
        self._far_first, self._patience = distance_rank == "far", patience
        self._parent_position, self._parent_velocity = self._position, self._velocity
        self._fitness: Array = np.full(len(self._position), np.inf)
        self._decay = DECAY_MAX
        self._unimproved = 0
        self._decay_step = REGULATING_SCALE * (DECAY_MAX - DECAY_MIN) / self._max_iterations  # (7)

    @property
    def stopped(self) -> str:
        """Why the run is over, as words; empty while it is not."""
        if self._patience is not None and self._unimproved >= self._patience:
            waited = f"no improvement in {self._patience} iterations"
        else:
            waited = ""
        return super().stopped or waited

    def _move(self) -> None:
        self._parent_position, self._parent_velocity = self._position, self._velocity
        super()._move()

    def _take(self, fitness: Array) -> None:
        if not self._history:
            super()._take(fitness)
            self._fitness = fitness
            return
        parent_personal, parent_best = self._personal.copy(), self._personal_fitness.copy()
        super()._take(fitness)
        error = np.concatenate((self._fitness, fitness))
        position = np.concatenate((self._parent_position, self._position))
        keep = survivors(
            error, position / (self._high - self._low), self._decay, far_first=self._far_first
        )
        self._position, self._fitness = position.take(keep, axis=0), error[keep]
        self._velocity = _kept(self._parent_velocity, self._velocity, keep)
        self._personal = _kept(parent_personal, self._personal, keep)
        self._personal_fitness = _kept(parent_best, self._personal_fitness, keep)
        self._cool(improved=float(self._personal_fitness.min()) < self._history[-1])

    def _cool(self, *, improved: bool) -> None:
        """Eq. (8) and (9) as printed: the scale falls only when the best error stays."""
        self._unimproved = 0 if improved else self._unimproved + 1
        lower = self._decay - self._decay_step
        if lower < DECAY_MIN:
            self._decay = DECAY_MIN
        elif not improved:
            self._decay = lower


def survivors(error: Array, position: Array, decay: float, *, far_first: bool) -> NDArray[np.intp]:
    """Returns which half of the individuals lives on, best score first: eq. (5), (6).

    Args:
        error: Values of the individuals, (2n,), infinite where discarded.
        position: Positions of the individuals in units of the box, (2n, d).
        decay: Weight rho of the distance rank.
        far_first: Whether the farthest from the best has distance rank 1, or the nearest.
    """
    best = int(error.argmin())
    away = position - position[best]
    squared = np.einsum("ij,ij->i", away, away)  # the root gives the same ranks
    score = _ranks(error) + decay * _ranks(-squared if far_first else squared)
    keep = score.argsort(kind="stable")[: error.size // 2]
    if best not in keep:
        keep[-1] = best
    return keep


def rank_distance_mpso(
    objective: Objective,
    bounds: Bounds,
    *,
    distance_rank: DistanceRank = "far",
    patience: int | None = None,
    inertia: Inertia = KAO_FUNG["inertia"],
    cognitive: float = KAO_FUNG["cognitive"],
    social: float = KAO_FUNG["social"],
    per_dimension: bool = KAO_FUNG["per_dimension"],
    callback: Callback | None = None,
    **common: Unpack[SwarmOptions],
) -> OptimizeResult:
    """Minimizes with the modified swarm of Kao and Fung 2009: eq. (3)-(9).

    The particles of the basic swarm and their offspring, one move later, compete: those with the
    lowest sum of error rank and decayed distance rank survive, and the best always does. What the
    paper leaves open: an individual takes its velocity and personal best with it, distances are
    measured in units of the box, and ranks start at 1 with ties in order, parents first.
    `RankDistanceMPSO` is the same as an ask/tell core that can be saved and resumed.

    Args:
        objective: Function to minimize, as `pso` takes it.
        bounds: One pair (low, high) per parameter.
        distance_rank: Individual that has distance rank 1, which is the best: "far", the farthest
            from the best solution, as the paper's figure 4 wants it; or "near", the nearest, as its
            "a higher rank to a longer distance" says word for word.
        patience: Number of iterations in a row without a better value that ends the run, the
            paper's second stop rule; it does not print the number. None never ends it so.
        inertia: Inertia of the velocity; by default the paper's in identification; "linear" is its
            eq. (4).
        cognitive: Coefficient c1, the pull towards a particle's own best.
        social: Coefficient c2, the pull towards the best of all.
        per_dimension: Whether random numbers are drawn for each dimension of each particle.
        callback: Function that gets the intermediate result, as `pso` calls it.
        **common: Options that every swarm takes; `SwarmOptions` lists them.

    Returns:
        The result, with the fields that `pso` lists; `population` is the survivors.
    """
    swarm = RankDistanceMPSO(
        bounds,
        distance_rank=distance_rank,
        patience=patience,
        inertia=inertia,
        cognitive=cognitive,
        social=social,
        per_dimension=per_dimension,
        **common,
    )
    return swarm.minimize(objective, callback)


def _ranks(values: Array) -> Array:
    ranks = np.empty(values.size)
    ranks[values.argsort(kind="stable")] = np.arange(1, values.size + 1)
    return ranks


def _kept(parents: Array, offspring: Array, keep: NDArray[np.intp]) -> Array:
    return np.concatenate((parents, offspring)).take(keep, axis=0)
