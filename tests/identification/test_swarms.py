"""The swarms against a readable transcription of each equation, and their contracts."""

import math

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.identification import mpso, pso, sa_pso
from activesuit.identification.mpso import scheduled_coefficients
from activesuit.identification.pso import tanh_coefficients
from activesuit.identification.sa_pso import selection_probability

SWARMS = {"pso": pso, "sa_pso": sa_pso, "mpso": mpso}
BOUNDS = [(-5.0, 5.0)] * 3


def sphere(x):
    return np.sum((x - 0.7) ** 2, axis=1)


def rosenbrock(x):
    return np.sum(100 * (x[:, 1:] - x[:, :-1] ** 2) ** 2 + (1 - x[:, :-1]) ** 2, axis=1)


def transcription(objective, bounds, size, iterations, seed, coefficients, temperature=None):
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
        r1, r2 = rng.random((2, size, 1))
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


@pytest.mark.parametrize(
    ("swarm", "coefficients", "options", "temperature"),
    [
        (pso, tanh_coefficients, {}, None),
        (mpso, scheduled_coefficients, {}, None),
        (sa_pso, tanh_coefficients, {"temperature": "paper"}, math.exp(-10)),
        (sa_pso, tanh_coefficients, {"temperature": "ln5"}, math.log(5)),
        (sa_pso, tanh_coefficients, {"temperature": 10.0}, 10.0),
    ],
)
def test_each_step_is_the_papers(swarm, coefficients, options, temperature):
    result = swarm(rosenbrock, BOUNDS, swarm_size=7, max_iterations=25, rng=4, **options)
    x, history = transcription(rosenbrock, BOUNDS, 7, 25, 4, coefficients, temperature)
    np.testing.assert_allclose(result.history, history, rtol=1e-9)
    np.testing.assert_allclose(result.x, x, rtol=1e-9)


def test_published_coefficients():
    # eq. (10) at k/K = 0, .25, .5, .75, 1 and eq. (14) at n/N = 0, .2, .4, .6, .8, 1
    inertia = [tanh_coefficients(k, 100)[0] for k in (0, 25, 50, 75, 100)]
    np.testing.assert_allclose(inertia, [0.95, 0.946, 0.675, 0.404, 0.40], atol=5e-4)
    c1 = [scheduled_coefficients(n, 100)[1] for n in (0, 20, 40, 60, 80, 100)]
    np.testing.assert_allclose(c1, [2.5, 2.5, 2.454, 1.599, 1.305, 1.3], atol=5e-4)
    np.testing.assert_allclose(scheduled_coefficients(0, 100), (0.9, 2.5, 0.5))
    np.testing.assert_allclose(scheduled_coefficients(100, 100), (0.4, 1.3, 1.7))


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
def test_finds_the_sphere(name):
    options = {"temperature": "ln5"} if name == "sa_pso" else {}
    result = SWARMS[name](sphere, BOUNDS, max_iterations=300, rng=1, **options)
    assert result.fun < 1e-6
    np.testing.assert_allclose(result.x, 0.7, atol=1e-3)
    assert result.success
    assert result.nfev == 50 * 301
    assert len(result.history) == 301
    assert (np.diff(result.history) <= 0).all()


@pytest.mark.parametrize("name", SWARMS)
def test_seed_target_callback(name):
    swarm = SWARMS[name]
    first, again = (swarm(sphere, BOUNDS, max_iterations=20, rng=3) for _ in range(2))
    np.testing.assert_array_equal(first.history, again.history)
    np.testing.assert_array_equal(first.x, again.x)
    assert swarm(sphere, BOUNDS, target=0.5, rng=3).fun < 0.5
    seen = []

    def stop(intermediate):
        seen.append(intermediate.fun)
        if len(seen) == 5:
            raise StopIteration

    stopped = swarm(sphere, BOUNDS, max_iterations=20, rng=3, callback=stop)
    assert stopped.nit == 5
    assert not stopped.success
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


@pytest.mark.parametrize(
    ("objective", "bounds", "options", "message"),
    [
        (sphere, [(1.0, -1.0)], {}, r"bounds\[0\] are \(1, -1\): .*low < high"),
        (sphere, [(0.0, np.inf)], {}, "give finite numbers"),
        (sphere, [1.0, 2.0], {}, r"bounds have shape \(2,\)"),
        (sphere, BOUNDS, {"swarm_size": 1}, "swarm_size is 1"),
        (sphere, BOUNDS, {"max_iterations": 0}, "max_iterations 0"),
        (sphere, BOUNDS, {"velocity_limit": 2.0}, "velocity_limit 2.0"),
        (lambda x: np.full(len(x), np.nan), BOUNDS, {}, "no finite value at any of the 50"),
        (lambda x: x, BOUNDS, {}, r"returned shape \(50, 3\)"),
    ],
)
def test_bad_input(objective, bounds, options, message):
    with pytest.raises(InputError, match=message):
        pso(objective, bounds, rng=0, **options)


@pytest.mark.parametrize("temperature", ["hot", -1.0, math.nan, 0])
def test_bad_temperature(temperature):
    with pytest.raises(InputError, match="temperature is"):
        sa_pso(sphere, BOUNDS, temperature=temperature)
