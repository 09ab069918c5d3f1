"""Static optimization against SciPy, and the bounds of activation dynamics."""

import math
from itertools import pairwise

import numpy as np
import pytest
from activesuit.envs.muscles.sharing import Cost, share
from scipy.optimize import LinearConstraint, minimize

MUSCLES, AXES, EQUAL = 12, 5, 3
RNG = np.random.default_rng(1)
LEVERS = RNG.normal(0, 20, (20, AXES, MUSCLES))
LEVERS[:, EQUAL:] = np.maximum(LEVERS[:, EQUAL:], 0)
TARGETS = np.einsum("nkm,nm->nk", LEVERS, RNG.uniform(0, 0.4, (20, MUSCLES)))
SOFT = 0.01
COSTS = {
    "squares": Cost(np.zeros(MUSCLES), 1.0, 0.0, SOFT),
    "cubes": Cost(np.zeros(MUSCLES), 0.05, 1.0, SOFT),
    "volume": Cost(RNG.uniform(0.2, 2, MUSCLES), 0.05, 0.0, SOFT),
}


def shared(
    cost, *, levers=LEVERS, wanted=TARGETS, least=0.0, dt=math.inf, equal=EQUAL, before=np.nan
):
    samples, _, muscles = levers.shape
    force, before = np.ones((samples, muscles)), np.broadcast_to(before, muscles).copy()
    return share(levers, force, wanted, equal, least, before, dt, cost)


def value(cost, a, reserve):
    muscle = cost.linear * a + cost.square * a**2 / 2 + cost.cubic * a**3 / 3
    return muscle.sum() + np.square(reserve).sum() / (2 * cost.softness)


@pytest.mark.parametrize("name", COSTS)
@pytest.mark.parametrize("least", [0.0, 0.05])
def test_scipy_finds_nothing_better(name, least):
    cost = COSTS[name]
    activation, reserve, missed = shared(cost, least=least)
    assert missed.max() < 1e-6
    for i in range(4):
        lever = np.hstack([LEVERS[i], np.eye(AXES)])
        found = minimize(
            lambda z: value(cost, z[:MUSCLES], z[MUSCLES:]),
            np.full(MUSCLES + AXES, 0.2),
            method="SLSQP",
            bounds=[(least, 1)] * MUSCLES + [(None, None)] * AXES,
            constraints=[
                LinearConstraint(lever[:EQUAL], TARGETS[i, :EQUAL], TARGETS[i, :EQUAL]),
                LinearConstraint(lever[EQUAL:], TARGETS[i, EQUAL:], np.inf),
            ],
            options={"maxiter": 2000, "ftol": 1e-14},
        )
        ours = value(cost, activation[i], reserve[i])
        assert ours <= found.fun + 1e-7
        assert ours == pytest.approx(found.fun, rel=1e-3)


def test_equations_hold_with_the_reserve():
    activation, reserve, _ = shared(COSTS["squares"])
    given = np.einsum("nkm,nm->nk", LEVERS, activation) + reserve - TARGETS
    assert np.abs(given[:, :EQUAL]).max() < 1e-6
    assert given[:, EQUAL:].min() > -1e-6
    assert given[:, EQUAL:].max() > 1  # more than was asked for, where that costs nothing
    assert np.abs(reserve).max() < 0.01 * np.abs(TARGETS).max()


def test_what_muscles_cannot_give_is_left_to_the_reserve():
    activation, reserve, missed = shared(COSTS["squares"], wanted=50 * TARGETS)
    assert activation.max() == 1 and missed.max() < 1e-6
    assert np.abs(reserve).max() > 100


def test_activation_takes_time():
    levers = np.repeat(LEVERS[:1], 12, axis=0)
    wanted = np.repeat(0.0 * TARGETS[:1], 12, axis=0)
    wanted[3:8] = 3 * TARGETS[0]
    free, late = (
        shared(COSTS["squares"], levers=levers, wanted=wanted, dt=dt)[0] for dt in (math.inf, 0.01)
    )
    assert np.abs(free[5] - free[7]).max() < 1e-6
    assert late[3].max() < free[3].max() and late[9].max() > free[9].max() + 0.02
    for before, now in pairwise(late):
        rate = 0.5 + 1.5 * before
        assert (now <= 1 - (1 - before) * np.exp(-0.01 / (0.01 * rate)) + 1e-12).all()
        assert (now >= before * np.exp(-0.01 * rate / 0.04) - 1e-12).all()


def test_a_motion_goes_on_from_the_activation_before():
    levers = np.repeat(LEVERS[:1], 12, axis=0)
    wanted = np.repeat(3 * TARGETS[:1], 12, axis=0)
    wanted[5:] = 0
    same = {"levers": levers, "wanted": wanted, "dt": 0.01}
    whole = shared(COSTS["squares"], **same)[0]
    same |= {"levers": levers[5:], "wanted": wanted[5:]}
    part = shared(COSTS["squares"], **same, before=whole[4])[0]
    np.testing.assert_allclose(part, whole[5:], atol=1e-6)
    assert shared(COSTS["squares"], **same)[0][0].max() < part[0].max() - 0.05
