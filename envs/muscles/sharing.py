"""Static optimization: the muscles that give wanted torques at the least cost, by their dual.

    min  sum over muscles of (linear a + square a²/2 + cubic a³/3)  +  |reserve|² / (2 softness)
    with lever a + reserve = wanted, in the last rows >= wanted,   low <= a <= high

The dual has one unknown x per row. The marginal cost of each muscle's activation equals lever' x,
as far as the bounds of the activation allow, and reserve = softness · x. In the last rows x is at
least 0. The gradient of the dual is piecewise smooth and the dual strongly convex, so that a
semismooth Newton method (Qi and Sun 1993), projected on the bounds of x (Bertsekas 1982), with a
line search on the dual, converges from any x. A sample starts from the x of the sample before.

Activation cannot change at once. In a control period activation stays between the activations that
excitations 0 and 1 would reach, by MuJoCo's activation dynamics after Millard et al. 2013: rate =
(excitation - a) / tau with tau = 10 ms (0.5 + 1.5 a) upwards, 40 ms / (0.5 + 1.5 a) downwards.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from ...arrays import Array
from ...kernels import inner

TRIES, HALVINGS = 100, 30
CLOSE = 1e-7  # [N·m], greatest miss of the equations
SLOPE = 1e-4  # share of the expected decrease that a step must have (Armijo)
ROUNDING = 1e-13  # share of the dual that may be lost to rounding
CURVED = 1e-12  # cubic coefficient below which the cost is a parabola


class Cost(NamedTuple):
    """The cost that is minimized, as coefficients of activation a."""

    linear: Array  # coefficient of a, shape (muscles,)
    square: float  # coefficient of a²/2
    cubic: float  # coefficient of a³/3
    softness: float  # square of the reserve torque that has a cost of 1/2 [N²·m²]


class Problem(NamedTuple):
    """The torques of one sample that are shared among muscles."""

    lever: Array  # torque of each muscle at full activation [N·m], shape (axes, muscles)
    wanted: Array  # torques [N·m], shape (axes,)
    equal: int  # number of rows that are equations; the later rows are inequalities
    low: Array  # least activation, shape (muscles,)
    high: Array  # greatest activation, shape (muscles,)
    cost: Cost


@inner
def activated(drive: float, square: float, cubic: float) -> float:
    """Returns the activation whose marginal cost is `drive`, at least 0."""
    if drive <= 0.0:
        return 0.0
    if cubic < CURVED:
        return drive / square
    return (math.sqrt(square * square + 4.0 * cubic * drive) - square) / (2.0 * cubic)


@inner
def evaluate(x: Array, of: Problem, a: Array, miss: Array) -> float:
    """Computes activations and the residuals of the equations; returns the dual function."""
    lever, wanted, cost = of.lever, of.wanted, of.cost
    axes, muscles = lever.shape
    value = 0.0
    for k in range(axes):
        miss[k] = cost.softness * x[k] - wanted[k]
        value += 0.5 * cost.softness * x[k] * x[k] - wanted[k] * x[k]
    for m in range(muscles):
        earned = 0.0
        for k in range(axes):
            earned += lever[k, m] * x[k]
        each = activated(earned - cost.linear[m], cost.square, cost.cubic)
        each = min(max(each, of.low[m]), of.high[m])
        a[m] = each
        price = cost.linear[m] + each * (0.5 * cost.square + each * cost.cubic / 3.0)
        value += each * (earned - price)
        for k in range(axes):
            miss[k] += lever[k, m] * each
    return value


@inner
def farthest(x: Array, miss: Array, equal: int) -> float:
    """Returns the greatest residual; in the last rows a positive one counts only where x > 0."""
    found = 0.0
    for k in range(x.size):
        if k < equal or x[k] > 0.0 or miss[k] < 0.0:
            found = max(found, abs(miss[k]))
    return found


@inner
def newton(x: Array, of: Problem, a: Array, miss: Array) -> Array:
    """Returns the step of Newton's method; unknowns that stay at their bound do not move."""
    lever, cost = of.lever, of.cost
    axes, muscles = lever.shape
    step, hessian = -miss, cost.softness * np.eye(axes)
    for m in range(muscles):
        if of.low[m] < a[m] < of.high[m]:
            slope = 1.0 / (cost.square + 2.0 * cost.cubic * a[m])
            for k in range(axes):
                for i in range(axes):
                    hessian[k, i] += slope * lever[k, m] * lever[i, m]
    for k in range(of.equal, axes):
        if x[k] <= 0.0 and miss[k] > 0.0:
            hessian[k, :], hessian[:, k] = 0.0, 0.0
            step[k], hessian[k, k] = 0.0, 1.0
    step[:] = np.linalg.solve(hessian, step)
    return step


@inner
def minimize(x: Array, of: Problem, a: Array) -> float:
    """Computes the activations `a` of one sample, from a start `x` of the dual, both in place.

    Returns the greatest residual [N·m].
    """
    axes = x.size
    miss, other = np.empty(axes), np.empty(axes)
    value = evaluate(x, of, a, miss)
    for _ in range(TRIES):
        if farthest(x, miss, of.equal) < CLOSE:
            break
        step, before = newton(x, of, a, miss), miss.copy()
        length, new = 1.0, value
        for _ in range(HALVINGS):
            promised = 0.0
            for k in range(axes):
                other[k] = x[k] + length * step[k]
                if k >= of.equal:
                    other[k] = max(other[k], 0.0)
                promised += before[k] * (other[k] - x[k])
            new = evaluate(other, of, a, miss)
            if new <= value + SLOPE * promised + ROUNDING * abs(value):
                break
            length *= 0.5
        x[:] = other
        value = new
    return farthest(x, miss, of.equal)


@njit(cache=True, nogil=True)
def share(
    arms: Array,
    force: Array,
    wanted: Array,
    equal: int,
    least: float,
    before: Array,
    dt: float,
    cost: Cost,
) -> tuple[Array, Array, Array]:
    """Shares the torques of a motion among muscles, sample after sample.

    Args:
        arms: Moment arms [m], shape (samples, axes, muscles).
        force: Force at full activation [N], shape (samples, muscles).
        wanted: Torques [N·m], shape (samples, axes).
        equal: Number of first axes with exactly the wanted torque; the other axes may have more.
        least: Least activation.
        before: Activation a period before the first sample, shape (muscles,); NaN if unknown.
        dt: Time between samples [s]; infinite for samples that are independent of each other.
        cost: The cost that is minimized.

    Returns:
        Activations, shape (samples, muscles); torques that the muscles cannot give [N·m], shape
        (samples, axes); greatest residual of each sample [N·m], shape (samples,).
    """
    samples, axes, muscles = arms.shape
    activation, reserve = np.empty((samples, muscles)), np.empty((samples, axes))
    missed, x, lever = np.empty(samples), np.zeros(axes), np.empty((axes, muscles))
    low, high = np.empty(muscles), np.ones(muscles)
    for n in range(samples):
        for m in range(muscles):
            low[m] = least
            a = activation[n - 1, m] if n > 0 else before[m]
            if dt < math.inf and not math.isnan(a):
                change = 0.5 + 1.5 * a
                low[m] = max(low[m], a * math.exp(-dt * change / 0.04))
                high[m] = max(low[m], 1.0 - (1.0 - a) * math.exp(-dt / (0.01 * change)))
            for k in range(axes):
                lever[k, m] = arms[n, k, m] * force[n, m]
        missed[n] = minimize(x, Problem(lever, wanted[n], equal, low, high, cost), activation[n])
        reserve[n] = cost.softness * x
    return activation, reserve, missed
