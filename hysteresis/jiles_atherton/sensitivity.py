"""The Jiles-Atherton torque along curves, with its derivatives with respect to every parameter.

Symbols and the exact step are those of `_bulk`. At a fixed effective field x the lag u obeys a
linear equation, so its derivatives v_j = du/dq_j obey the same equation with other sources: the
source of u is (c-1) dMan/dx; the source of v_j is its derivative with respect to q_j, plus
u / (delta k^2) for q_j = k. The step is differentiated as it is computed: its weights with respect
to k, the Hermite interpolant with respect to Ms and a. The relations between u and M,

    M = Man(x) + u(x),   x = H + alpha M,

give dM/dq_j = (dMan/dq_j + v_j + f M [q_j = alpha]) / (1 - alpha f), and v_j from dM/dq_j at the
beginning of the next motion, whose f belongs to its own direction.
"""

import math

import numpy as np
from numba import njit

from . import _forms as forms
from ._bulk import decay_weights, weigh
from .kernels import (
    ALPHA,
    ANGLE,
    CURVATURE,
    FIELD,
    LAG,
    MAN,
    MEMORY_SIZE,
    MS,
    PARAMETER_SIZE,
    PER_A,
    SLOPE,
    STEP_LIMIT,
    TORQUE,
    A,
    C,
    K,
    remember,
    set_parameters,
    store,
    travel,
)
from .langevin import fma, langevin

INITIAL = 5  # the torque at the beginning, after Ms, a, alpha, c, k
SERIES_TERMS = 9  # number of terms of phi_4 for z < 1


@njit(cache=True, nogil=True, error_model="numpy")
def response_and_derivatives(H, starts, M0, parameters, M, dM):
    """Fills M with the torque along several curves laid end to end, and dM with its derivatives.

    M is that of `population_response` to the last bit.

    Args:
        H: Angles of all curves (samples,).
        starts: Index of each curve's first sample, then the number of samples (curves + 1,).
        M0: Torque at each curve's first sample (curves,).
        parameters: Values of Ms, a, alpha, c, k in the unit of H (5,), form bulk without clamp.
        M: Torque (samples,); NaN from the pole on.
        dM: Derivatives of M with respect to Ms, a, alpha, c, k and the torque at the start
            (samples, 6).
    """
    p, s = np.zeros(PARAMETER_SIZE), np.zeros(MEMORY_SIZE)
    Ms, a, alpha, c, k = parameters
    set_parameters(p, Ms, a, alpha, c, k, forms.BULK, forms.NO_CLAMP)
    for curve in range(M0.size):
        first = starts[curve]
        remember(p, s, H[first], M0[curve])
        M[first], dM[first], dM[first, INITIAL] = M0[curve], 0.0, 1.0
        for i in range(first + 1, starts[curve + 1]):
            if H[i] == s[ANGLE]:
                dM[i] = dM[i - 1]
            else:
                moved = travel(p, s, H[i])
                carry(p, s, moved[0], dM[i - 1], dM[i])
                store(s, H[i], moved)
            M[i] = s[TORQUE]


@njit(cache=True, error_model="numpy")
def carry(p, s, end, before, after):
    """Fills `after` with the derivatives of M after a motion from s to the field `end`."""
    Ms, a, alpha, c, k = p[MS], p[A], p[ALPHA], p[C], p[K]
    x, u, man, slope, curvature = s[FIELD], s[LAG], s[MAN], s[SLOPE], s[CURVATURE]
    per_k = math.copysign(1 / k, end - x)
    f = c * slope - u * per_k
    g = 1 - alpha * f
    by_a, slope_by_a = -x * slope / a, -(slope + x * curvature) / a  # derivatives of Man
    v_Ms = g * before[MS] - man / Ms
    v_a = g * before[A] - by_a
    v_alpha = g * before[ALPHA] - f * (man + u)
    v_c, v_k, v_initial = g * before[C], g * before[K], g * before[INITIAL]
    steps = math.ceil(abs(end - x) / p[STEP_LIMIT])
    dx = (end - x) / max(steps, 1)
    weights, by_z = weights_and_derivatives(abs(dx) / k)
    z_by_k = -abs(dx) / (k * k)
    for _ in range(steps):
        x += dx
        L, dL, ddL = langevin(x * p[PER_A])
        man1, slope1, curvature1 = Ms * L, Ms / a * dL, Ms / a / a * ddL
        by_a1, slope_by_a1 = -x * slope1 / a, -(slope1 + x * curvature1) / a
        v_Ms = weigh(dx, v_Ms, man / Ms, slope / Ms, man1 / Ms, slope1 / Ms, c, weights)
        v_a = weigh(dx, v_a, by_a, slope_by_a, by_a1, slope_by_a1, c, weights)
        v_alpha *= weights[0]
        v_c = weigh(dx, v_c, man, slope, man1, slope1, 2.0, weights)
        by_weights = weigh(dx, u, man, slope, man1, slope1, c, by_z)
        v_k = fma(weights[0], v_k, by_weights * z_by_k)
        v_initial *= weights[0]
        u = weigh(dx, u, man, slope, man1, slope1, c, weights)
        man, slope, by_a, slope_by_a = man1, slope1, by_a1, slope_by_a1
    f = c * slope - u * per_k
    per_g = 1 / (1 - alpha * f)
    after[MS], after[A] = per_g * (v_Ms + man / Ms), per_g * (v_a + by_a)
    after[ALPHA] = per_g * (v_alpha + f * (man + u))
    after[C], after[K], after[INITIAL] = per_g * v_c, per_g * v_k, per_g * v_initial


@njit(inline="always", error_model="numpy")
def weights_and_derivatives(z):
    """Returns `decay_weights` and their derivatives d/dz: of phi_j it is j phi_(j+1) - phi_j."""
    decay, phi1, phi2, phi3 = decay_weights(z)
    phi4 = (1 / 6 - phi3) / z
    if z < 1:  # the closed form loses digits here; sum over j of (-z)^j / (j + 4)!
        term, phi4 = 1 / 24, 0.0
        for j in range(5, 5 + SERIES_TERMS):
            phi4 += term
            term *= -z / j
    by_z = -decay, phi2 - phi1, 2 * phi3 - phi2, 3 * phi4 - phi3
    return (decay, phi1, phi2, phi3), by_z
