"""The other forms of the Jiles-Atherton model, and the clamps: an adaptive step in the field.

The literature gives dM/dH for each form. Divided by dHe/dH = 1 + alpha dM/dH it becomes dM/dHe,
which is smooth also where dM/dH is infinite. With D = Man - M and the direction delta, dM/dHe is:

    bulk        D / (delta k) + c Man'                                           (Li et al. 2022)
    original    (D + c Man' (delta k - alpha D)) / ((1 + c) delta k - c alpha D)
                from dM/dH = (P + c dMan/dH) / (1 + c),  P = D / (delta k - alpha D)
                (Jiles and Atherton 1986)
    derivative  (P + c Man') / (1 + c + alpha P + alpha c Man')
                from the same with dMan/dHe for dMan/dH (Szewczyk and Cheng 2018)
    jiles-1992  ((1-c) D + c Man' ((1-c) delta k - alpha D)) / ((1-c) delta k - alpha c D)
                from dM/dH = (Q + c Man') / (1 - alpha c Man'),
                Q = (1-c) D / ((1-c) delta k - alpha D)  (Jiles, Thoelke and Devine 1992)

A clamp drops the irreversible part (the terms with D) while it points against the motion: `jiles`
when delta D < 0, the rule of magnetics; `irreversible` when the irreversible magnetization itself
would turn back, which for `bulk` and `jiles-1992` has the sign of delta D / (1 - c). The two differ
for c > 1 only.
"""

import math

from numba import njit

from .langevin import langevin

FORMS = ("bulk", "original", "derivative", "jiles-1992")
BULK, ORIGINAL, DERIVATIVE, JILES_1992 = range(4)
CLAMPS = ("none", "jiles", "irreversible")
NO_CLAMP, JILES_CLAMP, IRREVERSIBLE_CLAMP = range(3)

TOLERANCE = 1e-9  # error of a step, relative to Ms
LANDING_TOLERANCE = 1e-11  # error of the field at the end of a motion, relative to min(a, k)
MARCH_LIMIT = 1_000_000
LANDING_LIMIT = 80


@njit(cache=True, error_model="numpy")
def rate(x, M, delta, p):
    """Returns dM/dHe at the effective field x; `kernels` describes p."""
    Ms, a, alpha, c, k, _, form, clamp = p[:8]
    L, dL, _ = langevin(x / a)
    D, reversible = Ms * L - M, c * Ms * dL / a
    blocked = False
    if clamp == JILES_CLAMP or form in (ORIGINAL, DERIVATIVE):
        blocked = clamp != NO_CLAMP and delta * D < 0
    elif clamp == IRREVERSIBLE_CLAMP:
        blocked = delta * D * (1 - c) < 0
    if form == BULK:
        return reversible if blocked else D / (delta * k) + reversible
    if form == ORIGINAL:
        if blocked:
            return reversible / (1 + c)
        return (D + reversible * (delta * k - alpha * D)) / ((1 + c) * delta * k - c * alpha * D)
    if form == DERIVATIVE:
        if blocked:
            return reversible / (1 + c + alpha * reversible)
        rest = delta * k - alpha * D
        return (D + reversible * rest) / (delta * k + (c + alpha * reversible) * rest)
    if blocked:
        return reversible
    pin = (1 - c) * delta * k
    return ((1 - c) * D + reversible * (pin - alpha * D)) / (pin - alpha * c * D)


@njit(cache=True, error_model="numpy")
def try_step(dx, x, M, first, delta, p):
    """Returns (M, its error, the integral of M - Man, the rate) after a step of dx.

    Bogacki and Shampine's third order pair; `first` is the rate at the beginning.
    """
    Ms, a = p[0], p[1]
    middle = M + dx / 2 * first
    second = rate(x + dx / 2, middle, delta, p)
    third = rate(x + 0.75 * dx, M + 0.75 * dx * second, delta, p)
    end = M + dx * (2 * first + 3 * second + 4 * third) / 9
    last = rate(x + dx, end, delta, p)
    error = abs(dx * (-5 * first / 72 + second / 12 + third / 9 - last / 8))
    middle = (M + end) / 2 + dx / 8 * (first - last)
    lag0, lag1 = M - Ms * langevin(x / a)[0], end - Ms * langevin((x + dx) / a)[0]
    lag = dx / 6 * (lag0 + 4 * (middle - Ms * langevin((x + dx / 2) / a)[0]) + lag1)
    return end, error, lag, last


@njit(cache=True, error_model="numpy")
def advance(H0, M0, H1, p):
    """Moves the model monotonically from (H0, M0) to the angle H1.

    Returns (M1, loss): the torque there and the integral of (M - Man) dHe; M1 is NaN when H1 is not
    finite, or when the motion meets a pole of dM/dH.
    """
    if not math.isfinite(H1):
        return math.nan, 0.0
    Ms, a, alpha, _, k = p[:5]
    delta = 1.0 if H1 > H0 else -1.0
    x, M, loss = H0 + alpha * M0, M0, 0.0
    slope = rate(x, M, delta, p)
    dx = delta * 0.1 * min(a, k)
    for _ in range(MARCH_LIMIT):
        if not alpha * slope < 1:
            return math.nan, loss
        whole = (H1 - (x - alpha * M)) / (1 - alpha * slope)
        if abs(whole) <= abs(dx):
            end, part = land(whole, x, M, slope, H1, delta, p)
            if math.isfinite(end):
                return end, loss + part
            dx = 0.5 * whole
        end, error, part, last = try_step(dx, x, M, slope, delta, p)
        passed = delta * (x + dx - alpha * end - H1) > 0
        growth = min(4.0, 0.9 * (TOLERANCE * Ms / max(error, 1e-300)) ** (1 / 3))
        if error <= TOLERANCE * Ms and not passed:
            x, M, slope, loss = x + dx, end, last, loss + part
        elif abs(dx) <= 1e-14 * (abs(x) + a):
            return math.nan, loss
        dx *= 0.5 if passed else max(growth, 0.1)
    return math.nan, loss


@njit(cache=True, error_model="numpy")
def land(dx, x, M, slope, H1, delta, p):
    """Ends a motion at H1 by Newton on the last step's dx; NaN when that step is too long."""
    Ms, a, alpha, _, k = p[:5]
    for _ in range(LANDING_LIMIT):
        end, error, loss, last = try_step(dx, x, M, slope, delta, p)
        if not (error <= TOLERANCE * Ms and alpha * last < 1):
            break
        newton = -(x + dx - alpha * end - H1) / (1 - alpha * last)
        if abs(newton) <= LANDING_TOLERANCE * min(a, k):
            return end + last * newton, loss
        dx += newton
        if not delta * dx > 0:
            break
    return math.nan, 0.0
