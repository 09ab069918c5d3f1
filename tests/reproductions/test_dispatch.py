"""The three-unit cost benchmark: its table of points, its two optima, and a proof of them."""

import numpy as np
import pytest
from activesuit.reproductions import dispatch
from activesuit.reproductions.kao_fung_2009 import TABLE_1

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
    free = [[output[0], output[2]]]
    np.testing.assert_allclose(dispatch.outputs(free, relaxed=True)[0], output, atol=2e-4)
    assert np.allclose(dispatch.outputs(free)[0], output, atol=2e-4) == feasible


def valve_points(unit):
    """Returns where the cost of a unit has its kinks, with both limits, rising [MW]."""
    spacing = np.pi / dispatch.F[unit]
    inner = np.arange(dispatch.LOWEST[unit], dispatch.HIGHEST[unit], spacing)
    return np.append(inner, dispatch.HIGHEST[unit])


def test_the_printed_costs_are_those_of_this_problem():
    at = [[valve_points(0)[3], valve_points(2)[3]]]  # a meeting of valve points
    worst = dispatch.fuel_cost(dispatch.outputs(at))[0]
    assert worst == pytest.approx(TABLE_1["pso"][2], abs=1e-4)
    best = TABLE_1["rank-distance-mpso"][0]
    assert best == pytest.approx(dispatch.RELAXED_OPTIMUM, abs=1e-4)
    assert best + 0.4 < dispatch.OPTIMUM


def test_the_printed_table_contradicts_itself_if_the_best_cost_is_the_optimum():
    best, average, worst, reached = TABLE_1["rank-distance-mpso"][:4]
    largest = (reached * best + (100 - reached) * worst) / 100
    assert largest == pytest.approx(8234.0142, abs=1e-4)
    assert average > largest + 0.1
    assert TABLE_1["pso"][3] == 21
    assert TABLE_1["pso"][0] > worst  # none of these 21 is as low as the worst trial of MPSO


def test_every_repaired_row_is_a_dispatch_within_the_limits():
    low, high = np.array(dispatch.BOUNDS).T
    P = dispatch.outputs(low + np.random.default_rng(0).random((2000, 2)) * (high - low))
    np.testing.assert_allclose(P.sum(axis=1), dispatch.DEMAND, atol=1e-9)
    assert (dispatch.LOWEST - 1e-9 <= P).all()
    assert (dispatch.HIGHEST + 1e-9 >= P).all()


def lower_bounds(low, high, limits):
    """Bounds the cost less marginal (sum P - demand) from below on boxes of (P1, P3).

    Each unit alone on its interval: b P + c P^2 - marginal P is convex, and |sin| between two
    valve points is concave, so that its least value is at an end, or 0 at a valve point within.
    """
    marginal = 8.5  # $/MWh: any number is valid; near the mean slope the bounds are tight
    total = np.full(len(low), dispatch.DEMAND * marginal)
    slack_low = np.maximum(dispatch.DEMAND - high.sum(axis=1), limits[0])
    slack_high = np.minimum(dispatch.DEMAND - low.sum(axis=1), limits[1])
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


def proven_lower_bound(relaxed, precision):
    """Branch and bound over all (P1, P3): halves every box that may hold a lower cost."""
    limits = (-np.inf, np.inf) if relaxed else (dispatch.LOWEST[1], dispatch.HIGHEST[1])
    known = dispatch.RELAXED_OPTIMUM if relaxed else dispatch.OPTIMUM
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


@pytest.mark.parametrize("relaxed", [False, True])
def test_optimum_is_proven(relaxed):
    known = dispatch.RELAXED_OPTIMUM if relaxed else dispatch.OPTIMUM
    third = valve_points(2)[2]
    first = valve_points(0)[2] if relaxed else dispatch.DEMAND - dispatch.HIGHEST[1] - third
    cost = dispatch.fuel_cost(dispatch.outputs([[first, third]], relaxed=relaxed))[0]
    assert cost == pytest.approx(known, abs=1e-5)
    assert proven_lower_bound(relaxed, 1e-4) == known - 1e-4


@pytest.mark.parametrize("relaxed", [False, True])
@pytest.mark.parametrize("method", dispatch.METHODS)
def test_trials_are_seeded_and_reach_the_optimum(method, relaxed):
    options = {"trials": 20, "relaxed": relaxed, "seed": 1}
    first, again = (dispatch.cost_trials(method, **options) for _ in range(2))
    assert [trial.cost for trial in first] == [trial.cost for trial in again]
    known = dispatch.RELAXED_OPTIMUM if relaxed else dispatch.OPTIMUM
    for trial in first:
        assert trial.cost == trial.history[-1] >= known - 1e-6
        assert trial.missed == (trial.cost - known >= dispatch.REACHED)
        assert trial.history[int(trial.converged)] < trial.cost + dispatch.REACHED
    assert not all(trial.missed for trial in first)
