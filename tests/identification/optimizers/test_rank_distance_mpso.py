"""Rank-distance MPSO against a readable transcription of Kao and Fung 2009, eq. (3)-(9)."""

import numpy as np
import pytest
from activesuit.identification.optimizers.rank_distance_mpso import (
    RankDistanceMPSO,
    rank_distance_mpso,
    survivors,
)
from helpers import assert_refused

BOUNDS = [(-5.0, 5.0), (0.0, 300.0), (-1e-3, 1e-3)]


def valleys(x):
    unit = x / [5.0, 300.0, 1e-3]
    return np.sum(unit**2 + 0.3 * np.sin(12 * unit) ** 2, axis=1)


def transcription(objective, bounds, size, iterations, seed, distance_rank, inertia=None):
    """One individual and one rank at a time; an individual is (x, v, pbest, F(pbest), F(x))."""
    rng = np.random.default_rng(seed)
    low, high = np.array(bounds).T
    vmax = 0.2 * (high - low)
    X = [row * (high - low) + low for row in rng.random((size, len(low)))]
    V = [row * (2 * vmax) - vmax for row in rng.random((size, len(low)))]
    F = [float(objective(x[None])[0]) for x in X]
    parents = [(x, v, x, f, f) for x, v, f in zip(X, V, F, strict=True)]
    history, scales = [min(F)], [0.7]
    for t in range(iterations):
        w = 0.65 if inertia is None else 0.9 - 0.5 * t / iterations  # (4)
        gbest = min(parents, key=lambda one: one[3])[2]
        rand = rng.random((2, size, len(low)))
        offspring = []
        for j, (x_old, v_old, pbest, f_pbest, _) in enumerate(parents):
            own, group = rand[:, j]
            v = 0.7 * own * (pbest - x_old) + 2.05 * group * (gbest - x_old) + w * v_old  # (3)
            v = np.clip(v, -vmax, vmax)
            x = np.clip(x_old + v, low, high)
            f = float(objective(x[None])[0])
            offspring.append((x, v, x, f, f) if f < f_pbest else (x, v, pbest, f_pbest, f))
        both = parents + offspring  # 2 PS individuals
        best = min(both, key=lambda one: one[4])
        distance = [np.linalg.norm((one[0] - best[0]) / (high - low)) for one in both]  # (6)
        RE = [0] * len(both)
        RD = [0] * len(both)
        for rank, k in enumerate(sorted(range(len(both)), key=lambda k: both[k][4]), start=1):
            RE[k] = rank
        sign = -1 if distance_rank == "far" else 1
        for rank, k in enumerate(sorted(range(len(both)), key=lambda k: sign * distance[k]), 1):
            RD[k] = rank
        score = [RE[k] + scales[-1] * RD[k] for k in range(len(both))]  # (5)
        order = sorted(range(len(both)), key=lambda k: score[k])
        parents = [both[k] for k in order[:size]]
        if not any(one is best for one in parents):
            parents[-1] = best
        history.append(best[4])
        step = 1.25 * (0.7 - 0.005) / iterations  # (7)
        scale = scales[-1] - step if history[-1] == history[-2] else scales[-1]  # (8)
        scales.append(0.005 if scales[-1] - step < 0.005 else scale)  # (9)
    return history, scales, np.array([one[0] for one in parents])


@pytest.mark.parametrize("distance_rank", ["far", "near"])
@pytest.mark.parametrize("inertia", [None, "linear"])
def test_each_step_is_the_papers(distance_rank, inertia):
    options = {} if inertia is None else {"inertia": inertia}
    swarm = RankDistanceMPSO(
        BOUNDS, swarm_size=8, max_iterations=40, distance_rank=distance_rank, rng=2, **options
    )
    result = swarm.minimize(valleys)
    history, _, population = transcription(valleys, BOUNDS, 8, 40, 2, distance_rank, inertia)
    np.testing.assert_allclose(result.history, history, rtol=1e-9)
    np.testing.assert_allclose(result.population, population, rtol=1e-7, atol=1e-12)


def test_the_decay_scale_falls_only_without_improvement():
    swarm = RankDistanceMPSO(BOUNDS, swarm_size=8, max_iterations=40, rng=2)
    scales = []
    while not swarm.stopped:
        swarm.tell(valleys(swarm.ask()))
        scales.append(swarm.state()["changing"]["_decay"])
    _, expected, _ = transcription(valleys, BOUNDS, 8, 40, 2, "far")
    np.testing.assert_allclose(scales, expected, rtol=1e-12)
    assert scales[0] == 0.7
    # 0.0087 an iteration, were there 100
    assert min(-np.diff(np.unique(scales)[::-1])[:-1]) == pytest.approx(0.0086875 * 100 / 40)


def test_survivors_by_hand():
    error = np.array([1.0, 4.0, 2.0, 3.0])
    position = np.array([[0.0], [9.0], [1.0], [5.0]])
    # RE 1 4 2 3; far RD 4 1 3 2: scores with rho 0.7 3.8 4.7 4.1 4.4, with rho 2: 9 6 8 7
    assert survivors(error, position, 0.7, far_first=True).tolist() == [0, 2]
    # the best is not among the first two and takes the place of the last
    assert survivors(error, position, 2.0, far_first=True).tolist() == [1, 0]
    assert survivors(error, position, 2.0, far_first=False).tolist() == [0, 2]
    # equal errors: in order
    assert survivors(np.ones(4), np.zeros((4, 1)), 0.5, far_first=True).tolist() == [0, 1]


def test_both_stop_rules():
    def flat(x):
        return np.ones(len(x))

    waited = rank_distance_mpso(flat, BOUNDS, patience=7, rng=0)
    assert (waited.nit, waited.message) == (7, "no improvement in 7 iterations")
    assert waited.success
    full = rank_distance_mpso(flat, BOUNDS, max_iterations=6, patience=7, rng=0)
    assert (full.nit, full.message) == (6, "ran all iterations")
    assert rank_distance_mpso(flat, BOUNDS, rng=0).nit == 100


@pytest.mark.parametrize("distance_rank", ["far", "near"])
def test_never_loses_the_best(distance_rank):
    result = rank_distance_mpso(valleys, BOUNDS, distance_rank=distance_rank, rng=8)
    assert (np.diff(result.history) <= 0).all()
    assert result.fun == valleys(result.x[None])[0] == result.history[-1]
    assert (result.population == result.x).all(axis=1).any()


def test_bad_input():
    rows = [
        ({"distance_rank": "middle"}, "distance_rank is 'middle': use 'far' or 'near'"),
        ({"patience": 0}, "patience is 0: use at least 1"),
        ({"inertia": -0.1}, "inertia is -0.1"),
    ]
    assert_refused(lambda options: rank_distance_mpso(valleys, BOUNDS, **options), rows)
