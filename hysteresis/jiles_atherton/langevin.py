"""The Langevin function L(x) = coth x - 1/x and its derivatives, to machine precision."""

import math
from typing import Any

from numba import njit, types
from numba.extending import intrinsic

# Below this |x| the closed form loses digits to cancellation, and the series is exact to rounding.
# The joints of a suit work in this zone.
SERIES_BELOW = 0.42

# L(x) = x (C0 + C1 x^2 + ...), from coth x = sum 2^(2n) B_2n x^(2n-1) / (2n)!
C0, C1, C2, C3 = 1 / 3, -1 / 45, 2 / 945, -1 / 4725
C4, C5, C6 = 2 / 93555, -1382 / 638512875, 4 / 18243225
C7, C8 = -7234 / 325641566250, 87734 / 38979295480125
D1, D2, D3, D4, D5, D6, D7, D8 = (  # coefficients of L'
    (2 * n + 3) * C for n, C in enumerate((C1, C2, C3, C4, C5, C6, C7, C8))
)
E0, E1, E2, E3 = (2 * n * (2 * n + 1) * C for n, C in ((1, C1), (2, C2), (3, C3), (4, C4)))  # L''


def _fused(typing_context, x, y, z):
    """Returns x * y + z, rounded once: faster, and equal in every function that inlines it."""

    def codegen(context, builder, signature, arguments):
        return builder.fma(*arguments)

    real = types.float64
    return real(real, real, real), codegen


fma: Any = intrinsic(_fused)  # a float of three floats


@njit(inline="always", error_model="numpy")
def langevin_series(x: float) -> tuple[float, float, float]:
    """Returns the result of `langevin` for |x| < SERIES_BELOW, without a branch."""
    s = x * x
    # Grouped in pairs (Estrin) so that the processor can work on them side by side.
    s2 = s * s
    s4 = s2 * s2
    value = fma(
        s4,
        fma(s2, fma(s, fma(s, C8, C7), C6), fma(s, C5, C4)),
        fma(s2, fma(s, C3, C2), fma(s, C1, C0)),
    )
    slope = fma(
        s4,
        fma(s2, fma(s, fma(s, D8, D7), D6), fma(s, D5, D4)),
        fma(s2, fma(s, D3, D2), fma(s, D1, C0)),
    )
    curvature = fma(s2, fma(s, E3, E2), fma(s, E1, E0))
    return x * value, slope, x * curvature


@njit(cache=True, forceinline=True, error_model="numpy")
def langevin(x: float) -> tuple[float, float, float]:
    """Returns L(x), L'(x) and L''(x) for any finite x.

    L and L' are within 1e-14 relative; L'' is for predicting only (about 1e-5 relative).
    """
    if abs(x) < SERIES_BELOW:
        return langevin_series(x)
    e = math.exp(-2 * abs(x))
    inverse = 1 / abs(x)
    scale = 1 / (1 - e)
    coth = (1 + e) * scale
    csch2 = 4 * e * scale * scale
    sign = math.copysign(1.0, x)
    return (
        sign * (coth - inverse),
        inverse * inverse - csch2,
        sign * 2 * (coth * csch2 - inverse * inverse * inverse),
    )


@njit(cache=True, error_model="numpy")
def log_sinhc(x: float) -> float:
    """Returns log(sinh(x) / x), the integral of L from 0 to x."""
    s = x * x
    if s < SERIES_BELOW * SERIES_BELOW:
        low = C0 / 2 + s * (C1 / 4 + s * (C2 / 6 + s * (C3 / 8 + s * C4 / 10)))
        return s * (low + s**5 * (C5 / 12 + s * (C6 / 14 + s * (C7 / 16 + s * C8 / 18))))
    return abs(x) + math.log1p(-math.exp(-2 * abs(x))) - math.log(2 * abs(x))
