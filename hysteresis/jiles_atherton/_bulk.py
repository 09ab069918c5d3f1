"""The exact step of the Jiles-Atherton model, form "bulk" without clamp.

Symbols as in the paper (Li et al. 2022, eq. 1-4); all angles and a, k, alpha here are in one unit.

    He = H + alpha M      effective field          Man(He) = Ms L(He / a)      anhysteretic torque
    M  = Man + u          u obeys  du/dHe = -u / (delta k) + (c - 1) dMan/dHe

which is eq. (4) written for u, and linear for any c. One step integrates this equation exactly,
except that a cubic Hermite interpolant replaces Man, and solves He - alpha M = H by Newton's
method. The local error is bounded beforehand (`field_step_limit`), so no step is ever rejected.
"""

# The memory holds u, not M: the slope f, the loss and the certificate need u, and M - Man loses its
# digits where M is near Man. The memory also holds Man and its derivatives, so that a step does not
# compute the Langevin function at the beginning again.

import math
from typing import NamedTuple

from numba import njit

from .langevin import SERIES_BELOW, fma, langevin, langevin_series

MAX_LANGEVIN_4TH_DERIVATIVE = 0.1307  # max |L''''|, near |x| = 1.0
LOCAL_TOLERANCE = 1e-9  # error per step in He, relative to Ms
NEWTON_TOLERANCE = 1e-6  # relative to min(a, k); the error of M is of second order, 1e-12 c Ms
RESOLUTION = 1e-14  # smallest Newton step above rounding, relative to the angle
NEWTON_LIMIT = 60
SHORT = 0.25  # |dx / k| below which the decay weights come from their series
MARCH_LIMIT = 1_000_000
RECOVERY_TOLERANCE = 1e-6  # relative to min(a, k); the energy is stationary there
P0, P1, P2, P3, P4, P5, P6, P7 = (1 / math.factorial(j + 3) for j in range(8))


class Point(NamedTuple):
    """A point of a motion."""

    x: float  # effective field
    u: float  # lag M - Man
    man: float  # anhysteretic torque Man
    slope: float  # dMan/dx
    curvature: float  # second derivative of Man


class Law(NamedTuple):
    """Parameters of a model, and constants of every step."""

    Ms: float
    alpha: float
    c: float
    per_a: float  # 1 / a
    per_k: float  # 1 / k
    dx_max: float  # longest step in the effective field, from `field_step_limit`
    tolerance: float  # of the effective field at the end of a motion


@njit(cache=True, error_model="numpy")
def field_step_limit(Ms: float, a: float, alpha: float, c: float, k: float) -> float:
    """Returns the longest step in He whose error in M stays below LOCAL_TOLERANCE * Ms.

    The cubic Hermite interpolant of Man is off by at most dx^4/384 max|Man''''|. Weighted by the
    exponential kernel, this changes u by at most |c-1| dx/k times as much.
    """
    # The error and its limit are both proportional to Ms, which cancels.
    gain = abs(c - 1) * MAX_LANGEVIN_4TH_DERIVATIVE
    if gain == 0:
        return a
    return min(a, (384 * LOCAL_TOLERANCE * k / gain) ** 0.2 * a**0.8)


@njit(inline="always", error_model="numpy")
def stretched(dx_max, x, per_a):
    """Returns the step limit at the effective field x, which grows in saturation.

    There |L''''| is about 24 / |x/a|^5, so that steps up to a quarter of |x| keep the error bound,
    and a march takes logarithmically many steps.
    """
    return dx_max * max(1.0, 0.25 * abs(x) * per_a)


@njit(inline="always", error_model="numpy")
def short_decay_weights(z: float) -> tuple[float, float, float, float]:
    """Returns the result of `decay_weights` for z < SHORT, without a branch."""
    # phi_3 = sum over j of (-z)^j / (j + 3)!, grouped in pairs (Estrin); the rest is below 1e-12.
    z2 = z * z
    phi3 = fma(
        z2 * z2,
        fma(z2, fma(-z, P7, P6), fma(-z, P5, P4)),
        fma(z2, fma(-z, P3, P2), fma(-z, P1, P0)),
    )
    # Down from phi_3 each line multiplies the error by z; up from exp(-z) by 1 / z.
    phi2 = fma(-z, phi3, 0.5)
    phi1 = fma(-z, phi2, 1.0)
    return fma(-z, phi1, 1.0), phi1, phi2, phi3


@njit(inline="always", error_model="numpy")
def decay_weights(z: float) -> tuple[float, float, float, float]:
    """Returns exp(-z) and phi_1, phi_2, phi_3 at -z, for z >= 0.

    phi_j(-z) is the sum over i >= 0 of (-z)^i / (i + j)!, as in exponential integrators.
    """
    if z < SHORT:
        return short_decay_weights(z)
    decay = math.exp(-z)
    phi1 = (1 - decay) / z
    phi2 = (1 - phi1) / z
    return decay, phi1, phi2, (0.5 - phi2) / z


@njit(inline="always", error_model="numpy")
def step_field(dx, u0, man0, slope0, man1, slope1, c, per_k):
    """Returns u after He moved by `dx`, from (u0, man0, slope0) to (man1, slope1)."""
    return weigh(dx, u0, man0, slope0, man1, slope1, c, decay_weights(abs(dx * per_k)))


@njit(inline="always", error_model="numpy")
def weigh(dx, u0, man0, slope0, man1, slope1, c, weights):
    """Returns the result of `step_field` from the `decay_weights` of the step."""
    # The Hermite basis has the slopes 1 - 4t + 3t^2, 3t^2 - 2t and 6t - 6t^2 for t from 0 to 1, and
    # the integral of exp(-z (1 - t)) t^j dt is j! phi_(j+1).
    # The explicit fma rounds once: the scalar and the vector path agree to the last bit.
    decay, phi1, phi2, phi3 = weights
    start, end = fma(6.0, phi3, fma(-4.0, phi2, phi1)), fma(6.0, phi3, -2 * phi2)
    rise = fma(6.0, phi2, -12 * phi3)
    integral = fma(dx, fma(slope0, start, slope1 * end), (man1 - man0) * rise)
    return fma(c - 1, integral, u0 * decay)


@njit(inline="always", error_model="numpy")
def predict(left, at, law, per_k):
    """Returns 1 / (1 - alpha f), f = dM/dHe, and the step in He to first and to second order.

    `left` is the rest of the motion as a change of angle; `per_k` has the sign of the motion.
    """
    tangent = fma(law.c, at.slope, -at.u * per_k)
    per_g = 1 / fma(-law.alpha, tangent, 1.0)
    dx = left * per_g
    bend = law.alpha * fma(tangent - at.slope, per_k, -law.c * at.curvature)
    return per_g, dx, fma(-0.5 * bend * per_g * dx, dx, dx)


@njit(inline="always", error_model="numpy")
def correct(dx, H1, at, law, per_k, at_end, weights):
    """Returns the residual of a step dx in He, its Newton correction, and the point after both.

    `at_end` is the Langevin function at x + dx, `weights` the step's `decay_weights`. The
    correction is NaN past the pole.
    """
    L, dL, ddL = at_end
    chi = law.Ms * law.per_a
    man1, slope1, curvature1 = law.Ms * L, chi * dL, chi * law.per_a * ddL
    u1 = weigh(dx, at.u, at.man, at.slope, man1, slope1, law.c, weights)
    tangent = fma(law.c, slope1, -u1 * per_k)
    g = fma(-law.alpha, tangent, 1.0)
    residual = fma(-law.alpha, man1 + u1, at.x + dx - H1)
    # NaN fails every comparison, so that neither path takes a point past the pole for a landing.
    newton = -residual / g if g > 0 else math.nan
    # The correction is added to first order, without another Langevin function (NEWTON_TOLERANCE).
    return (
        residual,
        newton,
        Point(
            at.x + dx + newton,
            fma(tangent - slope1, newton, u1),
            fma(slope1, newton, man1),
            fma(curvature1, newton, slope1),
            curvature1,
        ),
    )


@njit(inline="always", error_model="numpy")
def advance_short(H0, H1, at, law):
    """Moves a model as `advance` does, without a branch, if one step inside both series is enough.

    Returns whether one step is enough, and the end of the motion, which is then equal to the end
    that `advance` computes, to the last bit.
    """
    # The expressions are those of `advance` and `land`: another order would round differently.
    delta = 1.0 if H1 > H0 else -1.0
    per_k = law.per_k * delta
    limit = stretched(law.dx_max, at.x, law.per_a)
    per_g, first, dx = predict(H1 - H0, at, law, per_k)
    end, z = (at.x + dx) * law.per_a, abs(dx * per_k)
    at_end, weights = langevin_series(end), short_decay_weights(z)
    _, newton, moved = correct(dx, H1, at, law, per_k, at_end, weights)
    # `and` would branch, and LLVM would no longer vectorize the loop over the models.
    in_series = (abs(end) < SERIES_BELOW) & (z < SHORT)
    in_limit = (per_g > 0) & (abs(first) <= limit) & (0 < delta * dx) & (delta * dx <= 2 * limit)
    landed = abs(newton) <= fma(RESOLUTION, abs(H1), law.tolerance)
    return in_series & in_limit & landed, moved


@njit(cache=True, forceinline=True, error_model="numpy")
def advance(H0, H1, at, law):
    """Moves the model monotonically from the angle H0, at the point `at`, to the angle H1.

    Returns the point of H1. There u is NaN if H1 is not finite, or if the motion meets the pole
    1 - alpha f = 0, where dM/dH is infinite and the model has no continuation.
    """
    if not math.isfinite(H1):
        return Point(at.x, math.nan, at.man, at.slope, at.curvature)
    delta = 1.0 if H1 > H0 else -1.0
    per_k = law.per_k * delta
    chi = law.Ms * law.per_a
    left = H1 - H0
    for _ in range(MARCH_LIMIT):
        per_g, first, dx = predict(left, at, law, per_k)
        if not per_g > 0:  # the state is past the pole, or NaN
            return Point(at.x, math.nan, at.man, at.slope, at.curvature)
        limit = stretched(law.dx_max, at.x, law.per_a)
        if abs(first) <= limit:
            # Near the pole the second-order guess can run off, even backwards.
            if not 0 < delta * dx <= 2 * limit:
                dx = delta * limit
            break
        dx = delta * limit
        L, dL, ddL = langevin((at.x + dx) * law.per_a)
        man1, slope1 = law.Ms * L, chi * dL
        u1 = step_field(dx, at.u, at.man, at.slope, man1, slope1, law.c, per_k)
        left1 = H1 - (at.x + dx - law.alpha * (man1 + u1))
        if delta * left1 <= 0:  # the step passes H1, and `land` shortens the step
            break
        at, left = Point(at.x + dx, u1, man1, slope1, chi * law.per_a * ddL), left1
    else:
        return Point(at.x, math.nan, at.man, at.slope, at.curvature)
    return land(dx, H1, at, law, delta)


@njit(cache=True, forceinline=True, error_model="numpy")
def land(dx, H1, at, law, delta):
    """Ends a motion at H1 by Newton's method on the length dx of the last step; see `advance`."""
    # H rises with dx up to the pole, so signs of the residual bracket the end. Newton alone can
    # leap past the pole, where g is near 0: a bisection or a doubled step replaces such a leap.
    tolerance, per_k = fma(RESOLUTION, abs(H1), law.tolerance), law.per_k * delta
    low, high = 0.0, math.inf
    for _ in range(NEWTON_LIMIT):
        at_end, weights = langevin((at.x + dx) * law.per_a), decay_weights(abs(dx * per_k))
        residual, newton, moved = correct(dx, H1, at, law, per_k, at_end, weights)
        if abs(newton) <= tolerance:
            return moved
        if delta * residual > 0:
            high = abs(dx)
        elif not math.isnan(newton):
            low = abs(dx)
        else:  # the state is past the pole and short of H1: no dx lands
            break
        reach = abs(dx) + delta * newton
        if not low < reach < high:
            reach = 0.5 * (low + high) if high < math.inf else 2 * abs(dx)
        dx = delta * reach
    return Point(at.x, math.nan, at.man, at.slope, 0.0)


@njit(cache=True, error_model="numpy")
def recoverable_energy(H, M, Ms, a, alpha, c, k, dx_max):
    """Returns the part of the past `loss` that a motion from (H, M) could still get back.

    This part is Willems' available storage of the irreversible part: while u opposes a return, a
    motion back gives work until u = 0, and no motion gives more (docs/theory.md, "Energy").
    """
    if c <= 1:
        return 0.0
    per_a, chi = 1 / a, Ms / a
    x = H + alpha * M
    L, dL, _ = langevin(x * per_a)
    man, slope = Ms * L, chi * dL
    u = M - man
    delta = -1.0 if u > 0 else 1.0
    per_k = delta / k
    gained = 0.0
    dx = 0.0
    for _ in range(MARCH_LIMIT):
        dx = -u / ((c - 1) * slope - u * per_k)
        limit = stretched(dx_max, x, per_a)
        if abs(dx) <= limit:
            break
        dx = delta * limit
        L, dL, _ = langevin((x + dx) * per_a)
        man1, slope1 = Ms * L, chi * dL
        u1 = step_field(dx, u, man, slope, man1, slope1, c, per_k)
        if u1 * u <= 0:
            break
        # The integral of u dHe, in closed form from the differential equation of u.
        gained += delta * k * ((u1 - u) - (c - 1) * (man1 - man))
        x, u, man, slope = x + dx, u1, man1, slope1
    for _ in range(NEWTON_LIMIT):
        L, dL, _ = langevin((x + dx) * per_a)
        man1, slope1 = Ms * L, chi * dL
        u1 = step_field(dx, u, man, slope, man1, slope1, c, per_k)
        newton = -u1 / ((c - 1) * slope1 - u1 * per_k)
        dx += newton
        if abs(newton) <= RECOVERY_TOLERANCE * min(a, k):
            man = man1 - man + slope1 * newton
            return max(gained - delta * k * (u + (c - 1) * man), 0.0)
    return gained
