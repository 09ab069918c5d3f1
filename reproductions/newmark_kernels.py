"""Kernel of the Bouc-Wen oscillator: Newmark's method with constant average acceleration."""

import math

from numba import njit

ITERATION_LIMIT = 50
TOLERANCE = 1e-13  # relative change of velocity and hysteretic force between iterations


@njit(inline="always", error_model="numpy")
def force_rate(v, z, alpha, bend, skew, nu):
    """The rate of z: alpha v - (bend |v| |z|^(nu-1) z + skew v |z|^nu)."""
    power = abs(z) if nu == 1 else abs(z) ** nu
    return alpha * v - bend * abs(v) * math.copysign(power, z) - skew * v * power


@njit(cache=True, nogil=True, error_model="numpy")
def newmark(mass, damping, stiffness, alpha, bend, skew, nu, dt, force, out):
    """Fills out with y [m] under force [N], both (samples,), from rest at y = z = 0.

    Each step solves for velocity and z by fixed-point iteration, which gains about
    dt^2 (stiffness + alpha) / (4 mass) per iteration: four digits in the benchmark.
    """
    y, v, z = 0.0, 0.0, 0.0
    a = force[0] / mass
    rate = 0.0
    out[0] = y
    half = 0.5 * dt
    for i in range(1, force.size):
        v1, z1 = v + dt * a, z + dt * rate
        y1, a1, rate1 = y, a, rate
        for _ in range(ITERATION_LIMIT):
            y1 = y + half * (v + v1)
            a1 = (force[i] - damping * v1 - stiffness * y1 - z1) / mass
            v2 = v + half * (a + a1)
            rate1 = force_rate(v2, z1, alpha, bend, skew, nu)
            z2 = z + half * (rate + rate1)
            near = abs(v2 - v1) <= TOLERANCE * abs(v2) and abs(z2 - z1) <= TOLERANCE * abs(z2)
            v1, z1 = v2, z2
            if near:
                break
        y, v, z, a, rate = y + half * (v + v1), v1, z1, a1, rate1
        out[i] = y
