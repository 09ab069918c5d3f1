"""The Langevin function L(x) = coth x - 1/x and its derivatives, to machine precision."""

import math

from numba import njit

# Below this |x| the closed form loses digits to cancellation, and the series is exact there.
# A suit works in exactly this zone.
SERIES_BELOW = 0.42

# L(x) = x (C0 + C1 x^2 + ...), from coth x = sum 2^(2n) B_2n x^(2n-1) / (2n)!
C0, C1, C2, C3 = 1 / 3, -1 / 45, 2 / 945, -1 / 4725
C4, C5, C6 = 2 / 93555, -1382 / 638512875, 4 / 18243225
C7, C8 = -7234 / 325641566250, 87734 / 38979295480125


@njit(inline="always", error_model="numpy")
def langevin(x: float) -> tuple[float, float, float]:
    """Returns L(x), L'(x) and L''(x) for any finite x.

    L and L' are within 1e-14 relative; L'' is for predicting only (about 1e-5 relative).
    """
    s = x * x
    if s < SERIES_BELOW * SERIES_BELOW:
        # Grouped in pairs (Estrin) so that the processor can work on them side by side.
        s2 = s * s
        s4 = s2 * s2
        value = ((C0 + s * C1) + s2 * (C2 + s * C3)) + s4 * (
            (C4 + s * C5) + s2 * (C6 + s * (C7 + s * C8))
        )
        slope = ((C0 + s * (3 * C1)) + s2 * (5 * C2 + s * (7 * C3))) + s4 * (
            (9 * C4 + s * (11 * C5)) + s2 * (13 * C6 + s * (15 * C7 + s * (17 * C8)))
        )
        curvature = (6 * C1 + s * (20 * C2)) + s2 * (42 * C3 + s * (72 * C4))
        return x * value, slope, x * curvature
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
