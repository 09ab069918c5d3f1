"""Solves the dimensionless Bouc-Wen equation: dw/dx = 1 - sigma w^n or its negative, w >= 0.

For n = 1 the solution is an exponential. For any other n a motion is a sequence of steps of three
kinds: a Taylor series of order 8, whose last terms bound its error; near w = 0, where w^n is not
smooth, the exact series of x(w), inverted by Newton's method; and for very large w the power law
that remains there. A motion of any length takes at most some hundred steps, and the short motion of
a simulation step takes one.
"""

import math

from numba import njit

TOLERANCE = (
    1e-12  # last Taylor term, relative to w; all later terms together are about 1/20 of this term
)
SERIES_BELOW, SERIES_END = 0.125, 0.25  # values of w^n at which the series begins and ends
SATURATED = 2e-15  # distance from the fixed point w = 1 that rounding cannot resolve
FAR = 1e16  # value of w^n beyond which the 1 in dw/dx is lost in rounding
HUGE = 1e300  # value of w^n that a decay from above reaches within a negligible x
# Every loop has a bound: a state that a user overwrites must not hang the engine.
MARCH_LIMIT = 100_000
SERIES_LIMIT = 64  # terms; 28 are enough below SERIES_END
SHORTENING_LIMIT = 100
NEWTON_LIMIT = 20


@njit(inline="always", error_model="numpy")
def taylor(w, u, sigma, h, per_n):
    """Returns the gain of w over n dx = h, the integral of w^(n+1) dx, and the error relative to w.

    v and p are the Taylor coefficients in t = n x of n w and of w^n. The model gives
    v_k = -sigma p_(k-1) / k, and p = w^n gives w p' = p (n w)', whose powers of t are

        w k p_k = sum over j = 1 ... k of (j - (k - j) / n) v_j p_(k-j).
    """
    r = 1 / w
    p0 = u
    v1 = 1 - sigma * p0
    p1 = r * v1 * p0
    v2 = -sigma * p1 / 2
    p2 = r * ((1 - per_n) * v1 * p1 + 2 * v2 * p0) / 2
    v3 = -sigma * p2 / 3
    p3 = r * ((1 - 2 * per_n) * v1 * p2 + (2 - per_n) * v2 * p1 + 3 * v3 * p0) / 3
    v4 = -sigma * p3 / 4
    p4 = (1 - 3 * per_n) * v1 * p3 + (2 - 2 * per_n) * v2 * p2 + (3 - per_n) * v3 * p1
    p4 = r * (p4 + 4 * v4 * p0) / 4
    v5 = -sigma * p4 / 5
    p5 = (1 - 4 * per_n) * v1 * p4 + (2 - 3 * per_n) * v2 * p3 + (3 - 2 * per_n) * v3 * p2
    p5 = r * (p5 + (4 - per_n) * v4 * p1 + 5 * v5 * p0) / 5
    v6 = -sigma * p5 / 6
    p6 = (1 - 5 * per_n) * v1 * p5 + (2 - 4 * per_n) * v2 * p4 + (3 - 3 * per_n) * v3 * p3
    p6 = r * (p6 + (4 - 2 * per_n) * v4 * p2 + (5 - per_n) * v5 * p1 + 6 * v6 * p0) / 6
    v7 = -sigma * p6 / 7
    p7 = (1 - 6 * per_n) * v1 * p6 + (2 - 5 * per_n) * v2 * p5 + (3 - 4 * per_n) * v3 * p4
    p7 = p7 + (4 - 3 * per_n) * v4 * p3 + (5 - 2 * per_n) * v5 * p2 + (6 - per_n) * v6 * p1
    p7 = r * (p7 + 7 * v7 * p0) / 7
    v8 = -sigma * p7 / 8
    gain = h * (v1 + h * (v2 + h * (v3 + h * (v4 + h * (v5 + h * (v6 + h * (v7 + h * v8)))))))

    # Taylor coefficients of w^(n+1) = w p, for the loss.
    g1 = w * p1 + per_n * v1 * p0
    g2 = w * p2 + per_n * (v1 * p1 + v2 * p0)
    g3 = w * p3 + per_n * (v1 * p2 + v2 * p1 + v3 * p0)
    g4 = w * p4 + per_n * (v1 * p3 + v2 * p2 + v3 * p1 + v4 * p0)
    g5 = w * p5 + per_n * (v1 * p4 + v2 * p3 + v3 * p2 + v4 * p1 + v5 * p0)
    g6 = w * p6 + per_n * (v1 * p5 + v2 * p4 + v3 * p3 + v4 * p2 + v5 * p1 + v6 * p0)
    g7 = w * p7 + per_n * (v1 * p6 + v2 * p5 + v3 * p4 + v4 * p3 + v5 * p2 + v6 * p1 + v7 * p0)
    area = g4 / 5 + h * (g5 / 6 + h * (g6 / 7 + h * g7 / 8))
    area = h * (w * p0 + h * (g1 / 2 + h * (g2 / 3 + h * (g3 / 4 + h * area))))

    # At the tolerance each term is some 1/30 of the previous term (1e-12^(1/8)), so the last term
    # bounds all later terms; 5 % of the 7th stands in where the 8th happens to vanish.
    last = h * h * h * h
    last = last * last * max(abs(v8), 0.05 * abs(v7 / h))
    return gain * per_n, area * per_n, last * per_n * r


@njit(inline="always", error_model="numpy")
def time_and_area(w, u, sigma, n):
    """Returns the integrals of dw / (1 - sigma w^n) and w^(n+1) dw / (1 - sigma w^n) from 0 to w.

    With u = w^n < 1 and t = sigma u the first is w times the sum of t^k / (k n + 1) over k >= 0,
    and the second sigma w^2 times the sum of t^k / (k n + 2) over k >= 1.
    """
    t = sigma * u
    time, area = 1.0, 0.0
    power, divisor = t, n + 1
    for _ in range(SERIES_LIMIT):
        if not abs(power) > 1e-17 * divisor:
            break
        time += power / divisor
        area += power / (divisor + 1)
        power *= t
        divisor += n
    return w * time, sigma * w * w * area


@njit(cache=True, error_model="numpy")
def near_zero(w, u, x, sigma, direction, n):
    """Solves `flow` up to the end of the series; returns w, the rest of x, the integral."""
    time, area = time_and_area(w, u, sigma, n)
    target = time + direction * x
    if target <= 0:
        return 0.0, -target, area
    end = SERIES_END ** (1 / n)
    if direction > 0:
        time_end, area_end = time_and_area(end, SERIES_END, sigma, n)
        if target >= time_end:
            return end, target - time_end, area_end - area
    # x(w) is convex for sigma = 1 and concave for -1, so that Newton's iterates approach the root
    # from one side from here: no bracket is needed.
    w1 = min(target, end)
    u1, area1, correction = u, area, 0.0
    for _ in range(NEWTON_LIMIT):
        u1 = w1**n
        time1, area1 = time_and_area(w1, u1, sigma, n)
        correction = (target - time1) * (1 - sigma * u1)
        w1 += correction
        if abs(correction) <= 1e-9 * w1:
            break
    # area1 belongs to w1 before its last correction, which is small enough for the first order.
    # Rounding must not make the integral of w^(n+1), a loss, negative.
    area1 += w1 * u1 * correction / (1 - sigma * u1)
    return w1, 0.0, max(direction * (area1 - area), 0.0)


@njit(cache=True, error_model="numpy")
def far_out(w, x, decay, n):
    """Solves `flow` where dw/dx = -decay w^n; returns w, the rest of x, the integral."""
    start = w
    if decay > 0:
        w = min(w, HUGE ** (1 / n))
        end = (0.5 * FAR) ** (1 / n)  # half of FAR, so that rounding cannot send w back here
        x_end = -math.expm1((n - 1) * math.log(end / w)) * end ** (1 - n) / (n - 1)
        if x >= x_end:
            return end, x - x_end, 0.5 * (start * start - end * end)
    growth = -math.log1p(decay * (n - 1) * x * w ** (n - 1)) / (n - 1)  # NaN past the pole
    w *= math.exp(growth)
    # The integral of w^(n+1) dx is that of w dw, since dw = -decay w^n dx.
    return w, 0.0, 0.5 * abs(start * start - w * w)


@njit(cache=True, error_model="numpy")
def march(w, x, sigma, direction, n):
    """Solves `flow` for sigma = +1 or -1 and n > 1."""
    total = 0.0
    longest = math.inf
    attracted = sigma > 0 and direction > 0
    for _ in range(MARCH_LIMIT):
        u = w**n
        if not u < FAR:  # true for NaN too, which is returned at once
            w, x, area = far_out(w, x, direction * sigma, n)
            total += area
            if not x > 0:
                return w, x, total
            continue
        if attracted and abs(w - 1) <= SATURATED:
            return 1.0, 0.0, total + x  # w^(n+1) = 1 all the way
        whole = n * x
        short = direction < 0 or u < SERIES_BELOW
        # A first guess, which the error of the Taylor step corrects below. Where w is small or
        # falls, it is at most a quarter of the way to w = 0, where w^n is singular.
        h = min(whole, 0.25 * n * w / (1 + u) if short else w / u, longest)
        if u < SERIES_BELOW and h < whole:
            w, x, area = near_zero(w, u, x, sigma, direction, n)
            total += area
            if x == 0 or w == 0:
                return w, x, total
            continue
        gain, area, error = taylor(w, u, sigma, direction * h, 1 / n)
        for _ in range(SHORTENING_LIMIT):
            if not error > TOLERANCE:
                break
            h *= max(0.1, 0.95 * (TOLERANCE / error) ** 0.125)
            gain, area, error = taylor(w, u, sigma, direction * h, 1 / n)
        total += direction * area
        # Rounding must not carry w across its fixed point: 1 is the certificate's bound of |z|.
        w = min(w + gain, 1.0) if attracted and w <= 1 else w + gain
        if h == whole:
            return w, 0.0, total
        x -= h / n
        longest = 1.5 * h
    return math.nan, 0.0, total


@njit(inline="always", error_model="numpy")
def exponential(w, x, sigma, direction):
    """Solves `flow` for sigma = +1 or -1 and n = 1."""
    rest = 0.0
    if direction < 0:
        to_zero = -sigma * math.log1p(-sigma * w)
        if x >= to_zero:
            rest = x - to_zero
            x = to_zero
    slope = 1 - sigma * w
    t = direction * x
    phi = -sigma * math.expm1(-sigma * t)
    lag = t - phi
    # w(t) = w + slope phi(t), squared and integrated term by term.
    area = w * w * t + 2 * w * slope * sigma * lag + slope * slope * (lag - 0.5 * sigma * phi * phi)
    w1 = 0.0 if rest > 0 else max(w + slope * phi, 0.0)
    return w1, rest, max(direction * area, 0.0)


@njit(inline="always", error_model="numpy")
def flow(w, x, sigma, direction, n):
    """Solves dw/dx = direction (1 - sigma w^n) over the length x, but not below w = 0.

    Returns w at the end (NaN past a pole), the part of x that is left when w reaches 0, and the
    integral of w^(n+1) |dx|.
    """
    if sigma == 0:
        end = w + direction * x
        return max(end, 0.0), max(-end, 0.0), 0.0  # the loss is sigma times the integral
    if n == 1:
        return exponential(w, x, sigma, direction)
    return march(w, x, sigma, direction, n)
