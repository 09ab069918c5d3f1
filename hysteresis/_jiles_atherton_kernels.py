"""Kernels of the Jiles-Atherton model: plain functions over scalars and arrays, compiled by numba.

Symbols as in the paper (Li et al. 2022, eq. 1-4); all angles and a, k, alpha here are in one unit.

    He = H + alpha M      effective field          Man(He) = Ms L(He / a)      anhysteretic torque
    M  = Man + u          u obeys  du/dHe = -u / (delta k) + (c - 1) dMan/dHe

which is eq. (4) written for u: linear in He, whatever c is. One step integrates it exactly but for
Man, replaced by its cubic Hermite interpolant, and solves He - alpha M = H by Newton. The local
error is bounded beforehand (`field_step_limit`), so no step is ever rejected.
"""

import math

from numba import njit

from ._langevin import langevin

MAX_LANGEVIN_4TH_DERIVATIVE = 0.1307  # max |L''''|, near |x| = 1.0
LOCAL_TOLERANCE = 1e-9  # of Ms, per step in He
NEWTON_TOLERANCE = 1e-6  # of min(a, k); the remainder enters to second order, about 1e-12 c Ms
NEWTON_LIMIT = 60
MARCH_LIMIT = 10_000
RECOVERY_TOLERANCE = 1e-4  # of min(a, k); the energy is stationary there, so this is plenty
P0, P1, P2, P3, P4, P5, P6, P7 = (1 / math.factorial(j + 3) for j in range(8))


@njit(cache=True, error_model="numpy")
def field_step_limit(Ms: float, a: float, alpha: float, c: float, k: float) -> float:
    """Returns the longest step in He whose error in M stays below LOCAL_TOLERANCE * Ms.

    The cubic Hermite interpolant of Man is off by at most dx^4/384 max|Man''''|; weighted by the
    exponential kernel that changes u by at most |c-1| dx/k times as much.
    """
    gain = abs(c - 1) * MAX_LANGEVIN_4TH_DERIVATIVE
    if gain == 0:
        return a
    return min(a, (384 * LOCAL_TOLERANCE * k / gain) ** 0.2 * a**0.8)


@njit(inline="always", error_model="numpy")
def stretched(dx_max, x, per_a):
    """Returns the step limit at the effective field x: it grows in saturation.

    There |L''''| is about 24 / |x/a|^5, so that steps up to a quarter of |x| keep the error bound,
    and a march takes logarithmically many steps.
    """
    return dx_max * max(1.0, 0.25 * abs(x) * per_a)


@njit(inline="always", error_model="numpy")
def decay_weights(z: float) -> tuple[float, float, float, float]:
    """Returns exp(-z) and phi_1, phi_2, phi_3 at -z, for z >= 0."""
    if z < 0.25:
        # sum over j of (-z)^j / (j + 3)!, grouped in pairs; the rest is below 1e-12.
        z2 = z * z
        phi3 = ((P0 - z * P1) + z2 * (P2 - z * P3)) + z2 * z2 * ((P4 - z * P5) + z2 * (P6 - z * P7))
        phi2 = 0.5 - z * phi3
        phi1 = 1 - z * phi2
        return 1 - z * phi1, phi1, phi2, phi3
    decay = math.exp(-z)
    phi1 = (1 - decay) / z
    phi2 = (1 - phi1) / z
    return decay, phi1, phi2, (0.5 - phi2) / z


@njit(inline="always", error_model="numpy")
def step_field(dx, u0, man0, slope0, man1, slope1, c, per_k):
    """Returns u after He moved by `dx`, from (u0, man0, slope0) to (man1, slope1)."""
    decay, phi1, phi2, phi3 = decay_weights(abs(dx * per_k))
    integral = dx * (slope0 * (phi1 - 4 * phi2 + 6 * phi3) + slope1 * (6 * phi3 - 2 * phi2)) + (
        man1 - man0
    ) * (6 * phi2 - 12 * phi3)
    return u0 * decay + (c - 1) * integral


@njit(cache=True, error_model="numpy")
def advance(H0, M0, H1, Ms, a, alpha, c, k, dx_max):
    """Moves the model monotonically from (H0, M0) to the angle H1.

    Returns (M1, loss): the torque at H1, and the path part of the work, the integral of u dHe (what
    of it is not `recoverable_energy` is lost). M1 is NaN when H1 is not finite, or when the motion
    meets the pole 1 - alpha f = 0, where dM/dH is infinite and the model has no continuation.
    """
    if H1 == H0:
        return M0, 0.0
    if not math.isfinite(H1):
        return math.nan, 0.0
    delta = 1.0 if H1 > H0 else -1.0
    per_a, per_k = 1 / a, delta / k
    chi = Ms * per_a
    x = H0 + alpha * M0
    L, dL, ddL = langevin(x * per_a)
    man, slope = Ms * L, chi * dL
    u = M0 - man
    loss = 0.0
    while True:
        tangent = c * slope - u * per_k
        g = 1 - alpha * tangent
        if not g > 0:
            return math.nan, loss
        limit = stretched(dx_max, x, per_a)
        dx = (H1 - (x - alpha * (man + u))) / g
        if abs(dx) <= limit:
            bend = alpha * ((tangent - slope) * per_k - c * chi * per_a * ddL)
            dx -= 0.5 * bend * dx * dx / g
            if not 0 < delta * dx <= 2 * limit:
                dx = delta * limit
            break
        dx = delta * limit
        L, dL, ddL = langevin((x + dx) * per_a)
        man1, slope1 = Ms * L, chi * dL
        u1 = step_field(dx, u, man, slope, man1, slope1, c, per_k)
        if delta * (x + dx - alpha * (man1 + u1) - H1) >= 0:
            break
        loss += delta * k * ((c - 1) * (man1 - man) - (u1 - u))
        x, u, man, slope = x + dx, u1, man1, slope1
    M1, last = land(x, u, man, slope, dx, H1, Ms, a, alpha, c, k, delta)
    return M1, loss + last


@njit(inline="always", error_model="numpy")
def land(x, u, man, slope, dx, H1, Ms, a, alpha, c, k, delta):
    """Ends a motion at H1: Newton, kept inside a bracket, on the last step's dx; see `advance`."""
    per_a, per_k = 1 / a, delta / k
    low, high = 0.0, math.inf
    for _ in range(NEWTON_LIMIT):
        L, dL, _ = langevin((x + dx) * per_a)
        man1, slope1 = Ms * L, Ms * per_a * dL
        u1 = step_field(dx, u, man, slope, man1, slope1, c, per_k)
        tangent = c * slope1 - u1 * per_k
        g = 1 - alpha * tangent
        residual = x + dx - alpha * (man1 + u1) - H1
        newton = -residual / g if g > 0 else math.nan
        if abs(newton) <= NEWTON_TOLERANCE * min(a, k):
            du = (tangent - slope1) * newton
            loss = delta * k * ((c - 1) * (man1 + slope1 * newton - man) - (u1 + du - u))
            return man1 + u1 + tangent * newton, loss
        if delta * residual > 0:
            high = abs(dx)
        elif g > 0:
            low = abs(dx)
        else:
            return math.nan, 0.0
        reach = abs(dx) + delta * newton
        if not low < reach < high:
            reach = 0.5 * (low + high) if high < math.inf else 2 * abs(dx)
        dx = delta * reach
    return math.nan, 0.0


@njit(cache=True, error_model="numpy")
def tangent_stiffness(H, M, delta, Ms, a, alpha, c, k):
    """Returns dM/dH for a motion in direction `delta` (+1 or -1) from (H, M), eq. (4)."""
    x = H + alpha * M
    L, dL, _ = langevin(x / a)
    f = c * Ms * dL / a - delta * (M - Ms * L) / k
    return f / (1 - alpha * f)


@njit(cache=True, error_model="numpy")
def anhysteretic(H, M, Ms, a, alpha):
    """Returns Man, the torque towards which the memory relaxes."""
    return Ms * langevin((H + alpha * M) / a)[0]


@njit(cache=True, error_model="numpy")
def certificate(Ms, a, alpha, c, k):
    """Returns the certificate's margin and its bound on |M - Man| (`JilesAtherton.certificate`)."""
    chi = Ms / (3 * a)
    spread = abs(c - 1)
    steepest = (spread + max(c, 0.0)) * chi
    most_negative = -(spread + max(-c, 0.0)) * chi
    return 1 - max(alpha * steepest, alpha * most_negative), k * spread * chi


@njit(cache=True, error_model="numpy")
def recoverable_energy(H, M, Ms, a, alpha, c, k, dx_max):
    """Returns the part of the past `loss` that a motion from (H, M) could still get back.

    It is Willems' available storage of the irreversible part: while u opposes a return, turning
    back gives work until u = 0, which is the best that any motion can do (docs: README, "Energy").
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


@njit(cache=True, error_model="numpy")
def response(H, M0, Ms, a, alpha, c, k, dx_max, M):
    """Fills M with the torque along the angles H, starting from M0; NaN from a pole onwards."""
    torque = M0
    for i in range(H.size):
        if i > 0:
            torque, _ = advance(H[i - 1], torque, H[i], Ms, a, alpha, c, k, dx_max)
        M[i] = torque


@njit(cache=True, nogil=True, error_model="numpy")
def population_response(H, starts, M0, parameters, M):
    """Fills M with the torque of n parameter rows along several curves laid end to end.

    Args:
        H: angles of all curves (samples,).
        starts: index of each curve's first sample, then the number of samples (curves + 1,).
        M0: torque at each curve's first sample (curves,).
        parameters: rows of Ms, a, alpha, c, k in the unit of H (n, 5).
        M: the result (n, samples).
    """
    for p in range(parameters.shape[0]):
        Ms, a, alpha, c, k = parameters[p]
        dx_max = field_step_limit(Ms, a, alpha, c, k)
        for curve in range(M0.size):
            part = slice(starts[curve], starts[curve + 1])
            response(H[part], M0[curve], Ms, a, alpha, c, k, dx_max, M[p, part])
