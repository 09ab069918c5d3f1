"""Kernels of the Jiles-Atherton model; `HysteresisModel` describes the protocol.

All angles are radians. Beyond angle, torque and loss, the memory holds the effective field,
u = M - Man, Man and the first two derivatives of Man, from which the next step starts.
"""

import math
from collections.abc import Callable

import numpy as np
from numba import njit

from . import _bulk as bulk
from . import _forms as forms
from .langevin import langevin, log_sinhc
from .margins import margin_everywhere

MS, A, ALPHA, C, K, STEP_LIMIT, FORM, CLAMP, PER_A, PER_K, TOLERANCE = range(11)
PARAMETER_SIZE = 11
ANGLE, TORQUE, LOSS, FIELD, LAG, MAN, SLOPE, CURVATURE = range(8)
MEMORY_SIZE = 8
SMALLEST = 1e-100  # least Ms, a and k; below, or above 1e100, the steps lose their digits
INITIAL = 5  # the torque at the beginning, after Ms, a, alpha, c, k
SERIES_TERMS = 9  # number of terms of phi_4 for z < 1
BLOCK = 32  # models of a population that take their steps together


@njit(cache=True, error_model="numpy")
def begin(p, s, angle, torque):
    """Starts a motion; returns how far |M - Man| is below its bound, negative if it is above."""
    remember(p, s, angle, torque)
    s[LOSS] = recoverable(p, angle, torque)  # `dissipated` then begins at 0
    _, bound = margin_everywhere(p[MS], p[A], p[ALPHA], p[C], p[K])
    return bound - abs(s[LAG])


@njit(cache=True, error_model="numpy")
def remember(p, s, angle, torque):
    """Writes angle, torque and the numbers that follow from both into s; the loss stays."""
    Ms, a = p[MS], p[A]
    x = angle + p[ALPHA] * torque
    L, dL, ddL = langevin(x / a)
    s[ANGLE], s[TORQUE], s[FIELD] = angle, torque, x
    s[LAG], s[MAN], s[SLOPE], s[CURVATURE] = torque - Ms * L, Ms * L, Ms / a * dL, Ms / a / a * ddL


@njit(inline="always", error_model="numpy")
def travel(p, s, angle, step: Callable = bulk.advance):
    """Returns the end of a motion to `angle` by the exact step; see `bulk.advance`."""
    at = bulk.Point(s[FIELD], s[LAG], s[MAN], s[SLOPE], s[CURVATURE])
    law = bulk.Law(p[MS], p[ALPHA], p[C], p[PER_A], p[PER_K], p[STEP_LIMIT], p[TOLERANCE])
    return step(s[ANGLE], angle, at, law)


@njit(inline="always", error_model="numpy")
def store(s, angle, moved):
    """Writes the point `moved`, which `travel` returned for the angle, into s; the loss stays."""
    s[FIELD], s[LAG], s[MAN], s[SLOPE], s[CURVATURE] = moved
    s[ANGLE], s[TORQUE] = angle, s[MAN] + s[LAG]


@njit(cache=True, inline="always", error_model="numpy")
def is_exact(p):
    """Returns whether the model has the form bulk and no clamp, for which the step is exact."""
    return p[FORM] == forms.BULK and p[CLAMP] == forms.NO_CLAMP


@njit(inline="always", error_model="numpy")
def loss_between(p, s, angle, lag, man):
    """Returns the integral of u dHe of the exact step, from its differential equation."""
    delta = 1.0 if angle > s[ANGLE] else -1.0
    return delta * p[K] * ((p[C] - 1) * (man - s[MAN]) - (lag - s[LAG]))


@njit(cache=True, error_model="numpy")
def move(p, s, angle):
    """Returns torque and loss after a monotone motion to another angle."""
    if not is_exact(p):
        return forms.advance(s[ANGLE], s[TORQUE], angle, p)
    _, lag, man, _, _ = travel(p, s, angle)
    return man + lag, loss_between(p, s, angle, lag, man)


@njit(cache=True, error_model="numpy")
def commit(p, s, angle):
    """Moves the memory on to `angle` and returns the torque; NaN leaves s as it is."""
    if angle == s[ANGLE]:
        return s[TORQUE]
    if not is_exact(p):
        torque, loss = forms.advance(s[ANGLE], s[TORQUE], angle, p)
        if not math.isnan(torque):
            remember(p, s, angle, torque)
            s[LOSS] += loss
        return torque
    moved = travel(p, s, angle)
    _, lag, man, _, _ = moved
    if not math.isnan(lag):
        s[LOSS] += loss_between(p, s, angle, lag, man)
        store(s, angle, moved)
    return man + lag


@njit(cache=True, error_model="numpy")
def stiffness(p, s, angle, torque, delta):
    """Returns dM/dH for a motion that goes on in direction `delta`."""
    x = angle + p[ALPHA] * torque
    f = forms.rate(x, torque, delta, p)
    return f / (1 - p[ALPHA] * f)


@njit(cache=True, error_model="numpy")
def recoverable(p, angle, torque):
    """Returns the part of the past loss that a motion from here could still get back."""
    if not is_exact(p):
        return 0.0
    return bulk.recoverable_energy(angle, torque, p[MS], p[A], p[ALPHA], p[C], p[K], p[STEP_LIMIT])


@njit(cache=True, error_model="numpy")
def stored(p, s, angle, torque, loss):
    """Returns the stored energy: the bracket in docs/theory.md, and the recoverable loss."""
    Ms, a, alpha = p[MS], p[A], p[ALPHA]
    elastic = Ms * a * log_sinhc((angle + alpha * torque) / a) - alpha * torque * torque / 2
    return elastic + recoverable(p, angle, torque)


@njit(cache=True, error_model="numpy")
def dissipated(p, s, angle, torque, loss):
    """Returns the dissipated energy: the loss less the part that a motion could still get back."""
    return s[LOSS] + loss - recoverable(p, angle, torque)


@njit(cache=True, error_model="numpy")
def is_sound(p):
    """Returns whether the kernels can rely on p, which a user of the engine can overwrite."""
    return min(p[MS], p[A], p[K]) > 0 and p[STEP_LIMIT] > 0


@njit(cache=True)
def memory_size(total):
    """Returns how many of these `total` numbers belong to the memory."""
    return MEMORY_SIZE


@njit(cache=True, error_model="numpy")
def set_parameters(p, Ms, a, alpha, c, k, form, clamp):
    """Fills p with parameters, form, clamp, and constants of every step."""
    p[MS], p[A], p[ALPHA], p[C], p[K] = Ms, a, alpha, c, k
    p[STEP_LIMIT] = bulk.field_step_limit(Ms, a, alpha, c, k)
    p[FORM], p[CLAMP] = form, clamp
    p[PER_A], p[PER_K], p[TOLERANCE] = 1 / a, 1 / k, bulk.NEWTON_TOLERANCE * min(a, k)


@njit(inline="always", error_model="numpy")
def advance_together(p, s, done, rows, angle):
    """Moves the models to `angle`, first by a short step, then the other models by long steps."""
    # Only this loop becomes vector instructions; the scalar steps below give the same bits.
    for row in rows:
        done[row], moved = travel(p[:, row], s[:, row], angle, bulk.advance_short)
        if done[row]:
            store(s[:, row], angle, moved)
    for row in rows:
        if not done[row]:
            store(s[:, row], angle, travel(p[:, row], s[:, row], angle))


@njit(cache=True, nogil=True, error_model="numpy")
def population_response(H, starts, M0, parameters, M):
    """Fills M with the torque of n parameter rows along several curves laid end to end.

    The models take each step together. The loop over the models has no branch and one array per
    quantity, and compiles to vector instructions: about six times as fast as one model after the
    other, with torques that are equal to the last bit.

    Args:
        H: Angles of all curves (samples,).
        starts: Index of each curve's first sample, then the number of samples (curves + 1,).
        M0: Torque of each row at each curve's first sample (n, curves).
        parameters: Rows of Ms, a, alpha, c, k in the unit of H (n, 5), form bulk without clamp.
        M: Result (n, samples).
    """
    p, s = np.zeros((PARAMETER_SIZE, BLOCK)), np.zeros((MEMORY_SIZE, BLOCK))
    done = np.empty(BLOCK, np.bool_)
    for first in range(0, len(parameters), BLOCK):
        rows = range(min(BLOCK, len(parameters) - first))
        for row in rows:
            Ms, a, alpha, c, k = parameters[first + row]
            set_parameters(p[:, row], Ms, a, alpha, c, k, forms.BULK, forms.NO_CLAMP)
        for curve in range(starts.size - 1):
            for row in rows:
                remember(p[:, row], s[:, row], H[starts[curve]], M0[first + row, curve])
            for i in range(starts[curve], starts[curve + 1]):
                if H[i] != s[ANGLE, 0]:
                    advance_together(p, s, done, rows, H[i])
                for row in rows:
                    M[first + row, i] = s[TORQUE, row]


@njit(cache=True, nogil=True, error_model="numpy")
def response_and_derivatives(H, starts, M0, parameters, M, dM):
    """Fills M with the torque along several curves laid end to end, and dM with its derivatives.

    The arguments are those of `population_response` for one row: M0 (curves,), parameters (5,) and
    M (samples,), which has the same torques to the last bit and is NaN from the pole on. dM
    (samples, 6) has the derivatives with respect to Ms, a, alpha, c, k and the torque at the start.

    At a fixed effective field x the lag u obeys a linear equation, so the derivatives v_j = du/dq_j
    obey the same equation with other sources: the source of u is (c-1) dMan/dx; the source of v_j
    is the derivative of that with respect to q_j, plus u / (delta k^2) for q_j = k. The computed
    step is differentiated: the weights with respect to k, and the Hermite interpolant with respect
    to Ms and a. The relations between u and M,

        M = Man(x) + u(x),   x = H + alpha M,

    give dM/dq_j = (dMan/dq_j + v_j + f M [q_j = alpha]) / (1 - alpha f), and v_j from dM/dq_j at
    the beginning of the next motion, with the f of the direction of that motion.
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
        v_Ms = bulk.weigh(dx, v_Ms, man / Ms, slope / Ms, man1 / Ms, slope1 / Ms, c, weights)
        v_a = bulk.weigh(dx, v_a, by_a, slope_by_a, by_a1, slope_by_a1, c, weights)
        v_alpha *= weights[0]
        v_c = bulk.weigh(dx, v_c, man, slope, man1, slope1, 2.0, weights)
        by_weights = bulk.weigh(dx, u, man, slope, man1, slope1, c, by_z)
        v_k = bulk.fma(weights[0], v_k, by_weights * z_by_k)
        v_initial *= weights[0]
        u = bulk.weigh(dx, u, man, slope, man1, slope1, c, weights)
        man, slope, by_a, slope_by_a = man1, slope1, by_a1, slope_by_a1
    f = c * slope - u * per_k
    per_g = 1 / (1 - alpha * f)
    after[MS], after[A] = per_g * (v_Ms + man / Ms), per_g * (v_a + by_a)
    after[ALPHA] = per_g * (v_alpha + f * (man + u))
    after[C], after[K], after[INITIAL] = per_g * v_c, per_g * v_k, per_g * v_initial


@njit(inline="always", error_model="numpy")
def weights_and_derivatives(z):
    """Returns `decay_weights` and their derivatives, as d phi_j / dz = j phi_(j+1) - phi_j."""
    decay, phi1, phi2, phi3 = bulk.decay_weights(z)
    phi4 = (1 / 6 - phi3) / z
    if z < 1:  # the closed form loses digits here; sum over j of (-z)^j / (j + 4)!
        term, phi4 = 1 / 24, 0.0
        for j in range(5, 5 + SERIES_TERMS):
            phi4 += term
            term *= -z / j
    by_z = -decay, phi2 - phi1, 2 * phi3 - phi2, 3 * phi4 - phi3
    return (decay, phi1, phi2, phi3), by_z
