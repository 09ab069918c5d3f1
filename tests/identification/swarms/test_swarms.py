"""The swarms against a readable transcription of each equation, and their contracts."""

import math
import pickle

import numpy as np
import pytest
from activesuit.identification.swarms.variants import (
    KAO_FUNG,
    MPSO,
    PSO,
    SAPSO,
    RankDistanceMPSO,
    linear_inertia,
    mpso,
    pso,
    rank_distance_mpso,
    sa_pso,
    scheduled_coefficients,
    selection_probability,
    tanh_inertia,
)
from helpers import assert_refused

SWARMS = {"pso": pso, "sa_pso": sa_pso, "mpso": mpso, "rank_distance": rank_distance_mpso}
CORES = {"pso": PSO, "sa_pso": SAPSO, "mpso": MPSO, "rank_distance": RankDistanceMPSO}
BOUNDS = [(-5.0, 5.0)] * 3
WIDE = [(-5.0, 5.0), (0.0, 300.0), (-1e-3, 1e-3)]
COLD = {"sa_pso": {"temperature": "ln5"}}  # as printed, the roulette never cools


def tanh_coefficients(k, K):
    return tanh_inertia(k, K), 2.0, 2.0


def sphere(x):
    return np.sum((x - 0.7) ** 2, axis=1)


def rosenbrock(x):
    return np.sum(100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2, axis=1)


def rastrigin(x):
    return 10 * x.shape[1] + np.sum(x**2 - 10 * np.cos(2 * np.pi * x), axis=1)


def transcription(objective, bounds, size, iterations, seed, coefficients, temperature=None, d=1):
    """Li et al. 2022, section 4.3, steps 1-12, one particle and one number at a time."""
    rng = np.random.default_rng(seed)
    low, high = np.array(bounds).T
    vmax = 0.2 * (high - low)
    P = [row * (high - low) + low for row in rng.random((size, len(low)))]  # (5)
    V = [row * (2 * vmax) - vmax for row in rng.random((size, len(low)))]  # (6)
    F = [float(objective(p[None])[0]) for p in P]
    pbest, fbest = [p.copy() for p in P], list(F)
    history = [min(fbest)]
    T = None
    for k in range(iterations):
        w, c1, c2 = coefficients(k, iterations)
        leader = pbest[int(np.argmin(fbest))]
        if temperature is not None:
            T = min(fbest) / temperature if k == 0 else T * 0.95  # (11)
            weights = [math.exp(-(f - min(fbest)) / T) for f in fbest]
            r3, total = rng.random(), 0.0
            for p, weight in zip(pbest, weights, strict=True):
                total += weight / sum(weights)  # (12)
                if total >= r3:
                    leader = p
                    break
        r1, r2 = rng.random((2, size, d))
        leader = leader.copy()
        for i in range(size):
            V[i] = w * V[i] + c1 * r1[i] * (pbest[i] - P[i]) + c2 * r2[i] * (leader - P[i])  # (8)
            V[i] = np.clip(V[i], -vmax, vmax)
            P[i] = np.clip(P[i] + V[i], low, high)  # (9)
            F[i] = float(objective(P[i][None])[0])
        for i in range(size):
            if F[i] < fbest[i]:
                pbest[i], fbest[i] = P[i].copy(), F[i]
        history.append(min(fbest))
    return pbest[int(np.argmin(fbest))], np.array(history)


def test_each_step_is_the_papers():
    linear = KAO_FUNG | {"inertia": "linear"}
    for swarm, coefficients, options, temperature, d in [
        (pso, tanh_coefficients, {}, None, 1),
        (pso, lambda k, K: (0.65, 0.7, 2.05), KAO_FUNG, None, 3),
        (pso, lambda k, K: (0.9 - 0.5 / K * k, 0.7, 2.05), linear, None, 3),
        (mpso, scheduled_coefficients, {}, None, 1),
        (sa_pso, tanh_coefficients, {"temperature": "paper"}, math.exp(-10), 1),
        (sa_pso, tanh_coefficients, {"temperature": "ln5"}, math.log(5), 1),
        (sa_pso, tanh_coefficients, {"temperature": 10.0}, 10.0, 1),
    ]:
        result = swarm(rosenbrock, BOUNDS, swarm_size=7, max_iterations=25, rng=4, **options)
        x, history = transcription(rosenbrock, BOUNDS, 7, 25, 4, coefficients, temperature, d)
        np.testing.assert_allclose(result.history, history, rtol=1e-9)
        np.testing.assert_allclose(result.x, x, rtol=1e-9)


def test_published_coefficients():
    # eq. (10) at k/K = 0, .25, .5, .75, 1 and eq. (14) at n/N = 0, .2, .4, .6, .8, 1
    inertia = [tanh_inertia(k, 100) for k in (0, 25, 50, 75, 100)]
    np.testing.assert_allclose(inertia, [0.95, 0.946, 0.675, 0.404, 0.40], atol=5e-4)
    c1 = [scheduled_coefficients(n, 100)[1] for n in (0, 20, 40, 60, 80, 100)]
    np.testing.assert_allclose(c1, [2.5, 2.5, 2.454, 1.599, 1.305, 1.3], atol=5e-4)
    np.testing.assert_allclose(scheduled_coefficients(0, 100), (0.9, 2.5, 0.5))
    np.testing.assert_allclose(scheduled_coefficients(100, 100), (0.4, 1.3, 1.7))
    assert [linear_inertia(k, 100) for k in (0, 50, 100)] == pytest.approx([0.9, 0.65, 0.4])


def test_the_printed_temperature_leaves_the_roulette_uniform():
    fitness = np.linspace(1.0, 3.0, 50)

    def perplexity(temperature):
        p = selection_probability(fitness, temperature)
        return math.exp(-np.sum(p * np.log(np.maximum(p, 1e-300))))

    last = 0.95**99
    assert perplexity(1.0 / math.exp(-10) * last) == pytest.approx(50.0, abs=0.01)
    assert perplexity(1.0 / math.log(5) * last) < 3
    assert selection_probability(fitness, 0.0).argmax() == 0


@pytest.mark.parametrize("name", SWARMS)
def test_seed_target_callback(name):
    swarm, seen = SWARMS[name], []
    first, again = (swarm(sphere, BOUNDS, max_iterations=20, rng=3) for _ in range(2))
    same(first, again)
    assert swarm(sphere, BOUNDS, target=0.5, rng=3).fun < 0.5

    def stop(intermediate):
        seen.append(intermediate.fun)
        if len(seen) == 5:
            raise StopIteration

    stopped = swarm(sphere, BOUNDS, max_iterations=20, rng=3, callback=stop)
    assert (stopped.nit, stopped.success) == (5, False)
    assert seen[-1] == stopped.fun == first.history[5]


@pytest.mark.parametrize("name", SWARMS)
def test_stays_in_bounds_and_discards_nan(name):
    bounds = [(0.0, 1.0), (-2.0, -1.0)]
    visited = []

    def spoiled(x):
        visited.append(x.copy())
        return np.where(x[:, 0] < 0.3, np.nan, x[:, 0] + x[:, 1])

    result = SWARMS[name](spoiled, bounds, rng=0, max_iterations=30)
    everywhere = np.concatenate(visited)
    assert (everywhere >= [0, -2]).all()
    assert (everywhere <= [1, -1]).all()
    assert result.discarded == int(np.count_nonzero(everywhere[:, 0] < 0.3)) > 0
    assert result.x[0] >= 0.3


def test_bad_input():
    rows = [
        (pso, [(1.0, -1.0)], {}, r"bounds\[0\] are \(1, -1\): .*low < high"),
        (pso, [(-1e308, 1e308)], {}, r"bounds\[0\] are .*low < high"),
        (pso, [(0.0, np.inf)], {}, "give finite numbers"),
        (pso, [1.0, 2.0], {}, r"bounds have shape \(2,\)"),
        (pso, BOUNDS, {"swarm_size": 1}, "swarm_size is 1"),
        (pso, BOUNDS, {"max_iterations": 0}, "max_iterations 0"),
        (pso, BOUNDS, {"max_iterations": math.nan}, "max_iterations nan"),
        (pso, BOUNDS, {"velocity_limit": 2.0}, "velocity_limit 2.0"),
        (pso, BOUNDS, {"inertia": "fast"}, "inertia is 'fast'"),
        (pso, BOUNDS, {"inertia": math.nan}, "inertia is nan"),
        (pso, BOUNDS, {"cognitive": -1.0}, "cognitive is -1.0"),
        (pso, BOUNDS, {"social": math.inf}, "social is inf"),
        (sa_pso, BOUNDS, {"temperature": "hot"}, "temperature is"),
        (sa_pso, BOUNDS, {"temperature": -1.0}, "temperature is"),
        (rank_distance_mpso, BOUNDS, {"distance_rank": "middle"}, "'middle': use 'far' or"),
        (rank_distance_mpso, BOUNDS, {"patience": 0}, "patience is 0: use at least 1"),
        (rank_distance_mpso, BOUNDS, {"inertia": -0.1}, "inertia is -0.1"),
    ]
    assert_refused(lambda swarm, bounds, options: swarm(sphere, bounds, **options), rows)
    wrong = [
        (lambda x: np.full(len(x), np.nan), "no finite value at any of the 50"),
        (lambda x: x, r"returned shape \(50, 3\)"),
    ]
    assert_refused(lambda objective: pso(objective, BOUNDS, rng=0), wrong)


@pytest.mark.parametrize("name", SWARMS)
def test_finds_known_optima(name):
    options = {"swarm_size": 100, "max_iterations": 400, "rng": 0, **COLD.get(name, {})}
    # Rastrigin: in the deepest valley, for the next holds 0.995; whoever keeps the particles that
    # are far away, as rank-distance MPSO does, polishes slowly
    for objective, optimum, reached in ((rosenbrock, 1.0, 1e-4), (rastrigin, 0.0, 0.1)):
        best = SWARMS[name](objective, BOUNDS[:2], **options)
        assert best.fun < reached
        np.testing.assert_allclose(best.x, optimum, atol=0.03)
        assert best.success
        assert (best.nfev, len(best.history)) == (100 * 401, 401)
        assert (np.diff(best.history) <= 0).all()


def hurdles(x):
    return np.where(x[:, 0] > 3, np.nan, rosenbrock(x))


def same(first, second):
    assert first.keys() == second.keys()
    for key in first:
        np.testing.assert_array_equal(first[key], second[key], err_msg=key)


@pytest.mark.parametrize("name", SWARMS)
def test_asked_and_resumed_equals_uninterrupted(name):
    options = {"swarm_size": 9, "max_iterations": 30, "rng": 5}
    whole, swarm = SWARMS[name](hurdles, BOUNDS, **options), CORES[name](BOUNDS, **options)
    while not swarm.stopped:
        positions = swarm.ask()
        np.testing.assert_array_equal(positions, swarm.ask())  # the same until `tell`
        fitness = hurdles(positions)
        positions[:] = np.nan  # the caller's own copy
        swarm.tell(fitness)
    same(swarm.result, whole)
    for rounds, asked in ((0, False), (0, True), (1, False), (12, False), (12, True)):
        swarm = CORES[name](BOUNDS, **options)
        for _ in range(rounds):
            swarm.tell(hurdles(swarm.ask()))
        if asked:
            swarm.ask()
        same(pickle.loads(pickle.dumps(swarm)).minimize(hurdles), whole)


def test_ask_and_tell_contract():
    swarm = PSO(BOUNDS, swarm_size=4, max_iterations=1, rng=0)
    early = [(np.zeros(4), "tell was called before ask")]
    assert_refused(lambda: swarm.result, [("no result before the first tell",)])
    assert_refused(swarm.tell, early)
    positions = swarm.ask()
    assert positions.shape == (4, 3)
    wrong = r"returned shape \(3,\) for positions of shape \(4, 3\)"
    assert_refused(swarm.tell, [(np.zeros(3), wrong)])
    swarm.tell(sphere(positions))
    assert not swarm.result.success
    assert_refused(swarm.tell, early)
    swarm.tell(sphere(swarm.ask()))
    assert swarm.stopped == "ran all iterations"
    assert_refused(swarm.ask, [(r"ask after the end \(ran all iterations\)",)])


def valleys(x):
    unit = x / [5.0, 300.0, 1e-3]
    return np.sum(unit**2 + 0.3 * np.sin(12 * unit) ** 2, axis=1)


def rank_transcription(objective, bounds, size, iterations, seed, distance_rank, inertia=None):
    """Kao and Fung 2009, eq. (3)-(9): one (x, v, pbest, F(pbest), F(x)) and one rank at a time."""
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
def test_each_step_of_rank_distance_is_the_papers(distance_rank, inertia):
    options = {} if inertia is None else {"inertia": inertia}
    given = {"swarm_size": 8, "max_iterations": 40, "rng": 2, **options}
    swarm = RankDistanceMPSO(WIDE, distance_rank=distance_rank, **given)
    result = swarm.minimize(valleys)
    history, _, population = rank_transcription(valleys, WIDE, 8, 40, 2, distance_rank, inertia)
    np.testing.assert_allclose(result.history, history, rtol=1e-9)
    np.testing.assert_allclose(result.population, population, rtol=1e-7, atol=1e-12)
    assert result.fun == valleys(result.x[None])[0] == result.history[-1]
    assert (result.population == result.x).all(axis=1).any()


def test_the_decay_scale_falls_only_without_improvement():
    swarm, scales = RankDistanceMPSO(WIDE, swarm_size=8, max_iterations=40, rng=2), []
    while not swarm.stopped:
        swarm.tell(valleys(swarm.ask()))
        scales.append(swarm._decay)
    _, expected, _ = rank_transcription(valleys, WIDE, 8, 40, 2, "far")
    np.testing.assert_allclose(scales, expected, rtol=1e-12)
    assert scales[0] == 0.7


def test_both_stop_rules_of_rank_distance():
    def flat(x):
        return np.ones(len(x))

    waited = rank_distance_mpso(flat, WIDE, patience=7, rng=0)
    assert (waited.nit, waited.message) == (7, "no improvement in 7 iterations")
    assert waited.success
    full = rank_distance_mpso(flat, WIDE, max_iterations=6, patience=7, rng=0)
    assert (full.nit, full.message) == (6, "ran all iterations")
    assert rank_distance_mpso(flat, WIDE, rng=0).nit == 100
