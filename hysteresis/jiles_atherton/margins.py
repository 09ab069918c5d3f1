"""The certificate of the Jiles-Atherton model: its margin for all angles and for a finite range.

In the effective field x the lag u = M - Man obeys du/dx = -u/(delta k) + (c-1) Man'. Suppose that
c >= 1 and every start has |u| <= B. Let U run to the right from u = B at the lowest angle,

    U' = ((c-1) k Man' - U) / k,  never below B,

and D to the left from u = -B at the highest angle, in the same way. Then D <= u <= U for ever:
a motion to the right cannot cross U, which solves the same equation; a motion to the left falls
faster than U does; and a motion that begins at the lowest angle with a smaller u begins below U,
because as long as 1 - alpha f > 0 the states of one angle rise faster from state to state than any
motion. So 1 - alpha f > 0 needs to hold between D and U only, at both ends of
f = c Man' - delta u / k.
"""

import math

from numba import njit

from ._bulk import step_field
from .langevin import langevin

CELL = 0.02  # step in the effective field, relative to min(a, k)
MAX_LANGEVIN_2ND_DERIVATIVE = 0.106  # max |L''|, near |x| = 1.37
CELLS_LIMIT = 1_000_000
BISECTIONS = 200


@njit(cache=True, error_model="numpy")
def margin_everywhere(Ms, a, alpha, c, k):
    """Returns the certificate's margin for all angles, and its bound on |M - Man|.

    The proof is in `JilesAtherton.certificate`.
    """
    chi = Ms / (3 * a)
    spread = abs(c - 1)
    steepest = (spread + max(c, 0.0)) * chi
    most_negative = -(spread + max(-c, 0.0)) * chi
    return 1 - max(alpha * steepest, alpha * most_negative), k * spread * chi


@njit(cache=True, error_model="numpy")
def margin_in_range(low, high, Ms, a, alpha, c, k):
    """Returns (margin, B, largest |u|) for angles between low and high.

    B is the largest |u| of a start, and covers every start without torque.
    """
    if c < 1 or alpha * Ms >= 3 * a:  # the latter: several fields belong to one angle and lag
        margin, bound = margin_everywhere(Ms, a, alpha, c, k)
        return margin, bound, bound
    start = Ms * langevin(max(abs(low), abs(high)) / a)[0]
    worst_right, up = run(low, high, start, Ms, a, alpha, c, k)
    worst_left, down = run(-high, -low, start, Ms, a, alpha, c, k)  # the model is odd
    return 1 - max(worst_right, worst_left), start, max(up, down)


@njit(cache=True, error_model="numpy")
def run(low, high, start, Ms, a, alpha, c, k):
    """Returns the largest alpha f along U from the angle low to high, and the largest U."""
    per_a, chi = 1 / a, Ms / a
    dx = CELL * min(a, k)
    x = field_at(low, start, Ms, a, alpha)
    L, dL, _ = langevin(x * per_a)
    man, slope, U = Ms * L, chi * dL, start
    worst, largest = 0.0, start
    for _ in range(CELLS_LIMIT):
        L, dL, _ = langevin((x + dx) * per_a)
        man1, slope1 = Ms * L, chi * dL
        U1 = max(start, step_field(dx, U, man, slope, man1, slope1, c, 1 / k))
        steepest = chi / 3 if x < 0 < x + dx else max(slope, slope1)
        inside = max(U, U1) + between(dx, U, U1, steepest, Ms, a, c, k)
        highest, lowest = c * steepest + inside / k, c * min(slope, slope1) - inside / k
        worst = max(worst, alpha * highest, alpha * lowest)
        largest = max(largest, inside)
        x, U, man, slope = x + dx, U1, man1, slope1
        if worst >= 1 or x - alpha * (man + U) >= high:
            return worst, largest
    return math.inf, largest


@njit(inline="always", error_model="numpy")
def between(dx, U, U1, steepest, Ms, a, c, k):
    """Returns by how much U can exceed its values at both ends of a cell: dx^2 / 8 max |U''|."""
    source = (c - 1) * steepest  # (c-1) Man'; U' is this less U / k
    bend = (c - 1) * MAX_LANGEVIN_2ND_DERIVATIVE * Ms / (a * a)
    return dx * dx / 8 * (bend + (source + (max(U, U1) + dx * source) / k) / k)


@njit(cache=True, error_model="numpy")
def field_at(H, u, Ms, a, alpha):
    """Returns the effective field of the state with angle H and lag u."""
    reach = abs(alpha) * (Ms + abs(u))
    below, above = H - reach, H + reach
    for _ in range(BISECTIONS):
        x = 0.5 * (below + above)
        if x - alpha * (Ms * langevin(x / a)[0] + u) < H:
            below = x
        else:
            above = x
    return below
