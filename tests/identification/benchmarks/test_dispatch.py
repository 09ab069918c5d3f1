"""The three-unit cost benchmark: its table of points, its two optima, and a proof of them."""

import itertools

import numpy as np
import pytest
from activesuit.errors import InputError
from activesuit.identification.benchmarks import dispatch
from activesuit.identification.optimizers import mpso
from activesuit.published import KAO_TABLE_1, WALTERS_DEMAND
from scipy.optimize import minimize_scalar

# Outputs [MW], cost [$/h], whether all limits hold.
POINTS = [
    ((299.4662, 400.8007, 149.7331), 8233.660724, False),
    ((300.2669, 400.0000, 149.7331), 8234.071730, True),
    ((301.0676, 399.1993, 149.7331), 8234.474809, True),
    ((498.9324, 251.2010, 99.8666), 8241.174314, True),
    ((399.1993, 400.0000, 50.8007), 8241.587522, True),
    ((399.1993, 251.2010, 199.5997), 8250.204685, True),
]


@pytest.mark.parametrize(("output", "cost", "feasible"), POINTS)
def test_published_points(output, cost, feasible):
    # The outputs are rounded to 1e-4 MW, where the cost slopes by up to 20 $/MWh.
    assert dispatch.fuel_cost([output])[0] == pytest.approx(cost, abs=4e-3)
    inside = (np.array(output) >= dispatch.LOWEST) & (np.array(output) <= dispatch.HIGHEST)
    assert inside.all() == feasible
    free = [[output[0], output[2]]]
    relaxed = dispatch.outputs(free, relax_slack_bound=True)[0]
    np.testing.assert_allclose(relaxed, output, atol=2e-4)
    kept = dispatch.outputs(free)[0]
    assert np.allclose(kept, output, atol=2e-4) == feasible


def test_the_printed_worst_cost_is_a_meeting_of_valve_points():
    at = [[dispatch.valve_points(0)[3], dispatch.valve_points(2)[3]]]
    assert dispatch.dispatch_cost(at)[0] == pytest.approx(KAO_TABLE_1["pso"].worst, abs=1e-4)


def test_every_repaired_row_is_a_dispatch_within_the_limits():
    rng = np.random.default_rng(0)
    low, high = np.array(dispatch.BOUNDS).T
    P = dispatch.outputs(low + rng.random((2000, 2)) * (high - low))
    np.testing.assert_allclose(P.sum(axis=1), WALTERS_DEMAND, atol=1e-9)
    assert (dispatch.LOWEST - 1e-9 <= P).all()
    assert (dispatch.HIGHEST + 1e-9 >= P).all()


def best_at_valve_points(relax):
    """Two units at a valve point or limit, the third making the rest; then a line search."""
    best = np.inf, np.empty(3)
    limits = [dispatch.HIGHEST.copy() for _ in range(2)]
    limits[1][1] = np.inf
    highest = limits[relax]
    for closing in range(3):
        first, second = (unit for unit in range(3) if unit != closing)
        for pair in itertools.product(dispatch.valve_points(first), dispatch.valve_points(second)):
            P = np.empty(3)
            P[[first, second]] = pair
            P[closing] = WALTERS_DEMAND - sum(pair)
            if dispatch.LOWEST[closing] <= P[closing] <= highest[closing]:
                best = min(best, (float(dispatch.fuel_cost(P[None])[0]), P), key=lambda it: it[0])
    cost, P = best
    for up, down in itertools.permutations(range(3), 2):
        step = np.zeros(3)
        step[up], step[down] = 1.0, -1.0
        room = min(highest[up] - P[up], P[down] - dispatch.LOWEST[down], 5.0)
        if room > 0:
            along = minimize_scalar(
                lambda t, P=P, step=step: dispatch.fuel_cost((P + t * step)[None])[0],
                bounds=(0, room),
                method="bounded",
                options={"xatol": 1e-10},
            )
            cost = min(cost, float(along.fun))
    return cost


def lower_bounds(low, high, limits):
    """Bounds the cost less marginal (sum P - demand) from below on boxes of (P1, P3).

    Each unit alone on its interval: b P + c P^2 - marginal P is convex, and |sin| between two
    valve points is concave, so that its least value is at an end, or 0 at a valve point within.
    """
    marginal = 8.5  # $/MWh: any number is valid; near the mean slope the bounds are tight
    total = np.full(len(low), WALTERS_DEMAND * marginal)
    slack_low = np.maximum(WALTERS_DEMAND - high.sum(axis=1), limits[0])
    slack_high = np.minimum(WALTERS_DEMAND - low.sum(axis=1), limits[1])
    intervals = {0: (low[:, 0], high[:, 0]), 1: (slack_low, slack_high), 2: (low[:, 1], high[:, 1])}
    for unit, (start, end) in intervals.items():
        b, c = dispatch.B[unit] - marginal, dispatch.C[unit]
        at = np.clip(-b / (2 * c), start, end)
        total += dispatch.A[unit] + b * at + c * at**2
        f, origin = dispatch.F[unit], dispatch.LOWEST[unit]
        phases = [f * (edge - origin) / np.pi for edge in (start, end)]
        valve_within = np.floor(phases[1]) > np.floor(phases[0])
        ends = np.minimum(*(np.abs(np.sin(np.pi * phase)) for phase in phases))
        total += dispatch.E[unit] * np.where(valve_within, 0.0, ends)
    return np.where(slack_low <= slack_high, total, np.inf)


def proven_lower_bound(relax, precision):
    """Branch and bound over all (P1, P3): halves every box that may hold a lower cost."""
    limits = (-np.inf, np.inf) if relax else (dispatch.LOWEST[1], dispatch.HIGHEST[1])
    known = dispatch.RELAXED_OPTIMUM if relax else dispatch.OPTIMUM
    low, high = (edge[None] for edge in np.array(dispatch.BOUNDS).T)
    for _ in range(60):
        open_boxes = lower_bounds(low, high, limits) < known - precision
        low, high = low[open_boxes], high[open_boxes]
        if not len(low):
            return known - precision
        axis = np.argmax(high - low, axis=1)
        rows = np.arange(len(low))
        middle = (low[rows, axis] + high[rows, axis]) / 2
        upper, lower = low.copy(), high.copy()
        upper[rows, axis], lower[rows, axis] = middle, middle
        low, high = np.concatenate([low, upper]), np.concatenate([lower, high])
    return -np.inf


@pytest.mark.parametrize("relax", [False, True])
def test_optimum_is_proven(relax):
    known = dispatch.RELAXED_OPTIMUM if relax else dispatch.OPTIMUM
    assert best_at_valve_points(relax) == pytest.approx(known, abs=1e-5)
    assert proven_lower_bound(relax, 1e-4) == known - 1e-4


def test_the_printed_best_cost_needs_the_relaxed_slack():
    printed = KAO_TABLE_1["rank-distance-mpso"].best
    assert dispatch.RELAXED_OPTIMUM == pytest.approx(printed, abs=1e-4)
    assert printed + 0.4 < dispatch.OPTIMUM


@pytest.mark.parametrize("relax", [False, True])
def test_a_swarm_gets_there(relax):
    def objective(free):
        return dispatch.dispatch_cost(free, relax_slack_bound=relax)

    known = dispatch.RELAXED_OPTIMUM if relax else dispatch.OPTIMUM
    costs = [mpso(objective, dispatch.BOUNDS, swarm_size=100, rng=seed).fun for seed in range(10)]
    assert min(costs) == pytest.approx(known, abs=1e-2)
    assert min(costs) >= known - 1e-6


@pytest.mark.parametrize("call", [dispatch.fuel_cost, dispatch.dispatch_cost])
def test_wrong_shape(call):
    with pytest.raises(InputError, match=r"has shape \(4,\): use \(n, "):
        call([1.0, 2.0, 3.0, 4.0])


def test_trials_are_seeded_and_reach_the_optimum():
    first, again = (list(dispatch.cost_trials("pso", trials=4, seed=1)) for _ in range(2))
    assert [trial.cost for trial in first] == [trial.cost for trial in again]
    assert len({trial.cost for trial in first}) > 1
    for trial in first:
        assert trial.cost == trial.history[-1] >= dispatch.OPTIMUM - 1e-6
        assert trial.reached == (trial.cost - dispatch.OPTIMUM < dispatch.REACHED)
        assert trial.history[trial.converged] < trial.cost + dispatch.REACHED
    assert any(trial.reached for trial in first)


def test_bad_trials():
    with pytest.raises(InputError, match="did you mean 'pso'"):
        next(dispatch.cost_trials("pos"))
    with pytest.raises(InputError, match="trials is 0"):
        next(dispatch.cost_trials("pso", trials=0))
