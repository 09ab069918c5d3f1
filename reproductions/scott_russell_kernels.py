"""Kernels of the piezo-driven mechanism: classical RK4 of many parameter sets side by side.

h does not depend on x, so that a step first finds h at the four stages of RK4, then moves x with
them. The inner loops run over parameter sets, which lie side by side for the vector registers.
"""

import numpy as np
from numba import njit

M, DAMPING, K, D_E, ALPHA, BETA, GAMMA, N = range(8)


@njit(inline="always", error_model="numpy")
def linear_rate(h, rate, alpha, beta, gamma):
    """Eq. (1) with n = 1."""
    return alpha * rate - beta * abs(rate) * h - gamma * rate * abs(h)


@njit(inline="always", error_model="numpy")
def power_rate(h, rate, alpha, beta, gamma, n):
    """Eq. (1): |h|^(n-1) h is |h|^n with the sign of h."""
    power = abs(h) ** n
    return alpha * rate - beta * abs(rate) * np.copysign(power, h) - gamma * rate * power


@njit(cache=True, nogil=True, error_model="numpy")
def linear_stages(p, rate, at, dt, h, h2, h3, h4):
    """Fills h2, h3, h4 with h at the stages after the first, and moves h to the end of the step."""
    alpha, beta, gamma = p[ALPHA], p[BETA], p[GAMMA]
    first, middle, last = rate[at], rate[at + 1], rate[at + 2]
    for i in range(h.size):
        k1 = linear_rate(h[i], first, alpha[i], beta[i], gamma[i])
        h2[i] = h[i] + 0.5 * dt * k1
        k2 = linear_rate(h2[i], middle, alpha[i], beta[i], gamma[i])
        h3[i] = h[i] + 0.5 * dt * k2
        k3 = linear_rate(h3[i], middle, alpha[i], beta[i], gamma[i])
        h4[i] = h[i] + dt * k3
        k4 = linear_rate(h4[i], last, alpha[i], beta[i], gamma[i])
        h[i] += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@njit(cache=True, nogil=True, error_model="numpy")
def power_stages(p, rate, at, dt, h, h2, h3, h4):
    """`linear_stages` for any n."""
    alpha, beta, gamma, n = p[ALPHA], p[BETA], p[GAMMA], p[N]
    first, middle, last = rate[at], rate[at + 1], rate[at + 2]
    for i in range(h.size):
        k1 = power_rate(h[i], first, alpha[i], beta[i], gamma[i], n[i])
        h2[i] = h[i] + 0.5 * dt * k1
        k2 = power_rate(h2[i], middle, alpha[i], beta[i], gamma[i], n[i])
        h3[i] = h[i] + 0.5 * dt * k2
        k3 = power_rate(h3[i], middle, alpha[i], beta[i], gamma[i], n[i])
        h4[i] = h[i] + dt * k3
        k4 = power_rate(h4[i], last, alpha[i], beta[i], gamma[i], n[i])
        h[i] += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@njit(cache=True, nogil=True, error_model="numpy")
def mechanism_step(stiffness, damping, d_e, voltage, at, dt, h, h2, h3, h4, x, v):
    """Moves x and v by eq. (2), divided by the mass; h as at the start of the step."""
    first, middle, last = voltage[at], voltage[at + 1], voltage[at + 2]
    half = 0.5 * dt
    for i in range(x.size):
        w, c, gain = stiffness[i], damping[i], d_e[i]
        a1 = w * (gain * (first - h[i]) - x[i]) - c * v[i]
        v2 = v[i] + half * a1
        a2 = w * (gain * (middle - h2[i]) - (x[i] + half * v[i])) - c * v2
        v3 = v[i] + half * a2
        a3 = w * (gain * (middle - h3[i]) - (x[i] + half * v2)) - c * v3
        v4 = v[i] + dt * a3
        a4 = w * (gain * (last - h4[i]) - (x[i] + dt * v3)) - c * v4
        x[i] += dt / 6 * (v[i] + 2 * v2 + 2 * v3 + v4)
        v[i] += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


@njit(cache=True, nogil=True, error_model="numpy")
def simulate(p, voltage, rate, dt, initial_h, linear, out):
    """Fills out (steps + 1, n) with x [m] of the parameter sets p (8, n), from rest.

    voltage [V] and rate [V/s] are given at every half step, 2 steps + 1 numbers each.
    """
    n = p.shape[1]
    stiffness, damping = p[K] / p[M], p[DAMPING] / p[M]
    h, v = np.full(n, initial_h), np.zeros(n)
    h2, h3, h4 = np.empty(n), np.empty(n), np.empty(n)
    x = p[D_E] * (voltage[0] - h)
    out[0] = x
    start = h.copy()
    for step in range(out.shape[0] - 1):
        start[:] = h
        if linear:
            linear_stages(p, rate, 2 * step, dt, h, h2, h3, h4)
        else:
            power_stages(p, rate, 2 * step, dt, h, h2, h3, h4)
        mechanism_step(stiffness, damping, p[D_E], voltage, 2 * step, dt, start, h2, h3, h4, x, v)
        out[step + 1] = x
