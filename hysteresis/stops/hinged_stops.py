"""Kernels of hinged stops: the kernels of stops, and a hinge function of the sum of stops.

    P = K (theta - rest) + sum w_i E_i,   T = offset + h(P)

Parameters p = [K, rest, r_1 ... r_n, w_1 ... w_n, offset, m, knots, values of h at the knots,
slopes], with room for `MOST_KNOTS` knots, of which m are used: piece j of h lies above j knots.

The memory is that of `prandtl_ishlinskii`, whose kernels compute P. The E_i differ by no more than
the thresholds, so in a monotone motion the stops begin to slip in the order of the thresholds.
"""

import math

from numba import njit

from . import prandtl_ishlinskii as stops
from .prandtl_ishlinskii import FIRST_PLAY, HEADER, START_TOLERANCE, dissipated, stop

__all__ = ["dissipated"]
MOST_KNOTS = 16
HINGE = 2 + 2 * MOST_KNOTS + MOST_KNOTS + 1  # numbers in p after the weights
OFFSET, COUNT, KNOTS, VALUES, SLOPES = 0, 1, 2, 2 + MOST_KNOTS, 2 + 2 * MOST_KNOTS  # indices


@njit(inline="always", error_model="numpy")
def piece(hinge, P):
    """Returns the index of the piece of h on which P lies; a knot belongs to the piece above."""
    j = 0
    while j < hinge[COUNT] and P >= hinge[KNOTS + j]:
        j += 1
    return j


@njit(inline="always", error_model="numpy")
def on_piece(hinge, j, P):
    """Returns the line of piece j at P."""
    k = max(j - 1, 0)
    return hinge[VALUES + k] + hinge[SLOPES + j] * (P - hinge[KNOTS + k])


@njit(cache=True, error_model="numpy")
def hinged(hinge, P):
    """Returns h(P)."""
    return on_piece(hinge, piece(hinge, P), P)


@njit(cache=True, error_model="numpy")
def unhinged(hinge, value, P):
    """Returns the argument of h nearest to P with the result `value`; infinite if none exists."""
    j = piece(hinge, P)
    if value > on_piece(hinge, j, P):
        while j < hinge[COUNT] and hinge[VALUES + j] < value:
            j += 1
    elif value < on_piece(hinge, j, P):
        while j > 0 and hinge[VALUES + j - 1] > value:
            j -= 1
    else:
        return P
    k, slope = max(j - 1, 0), hinge[SLOPES + j]
    return hinge[KNOTS + k] + (value - hinge[VALUES + k]) / slope


@njit(cache=True, error_model="numpy")
def mean(hinge, one, other):
    """Returns the mean of h between two numbers."""
    low, high = min(one, other), max(one, other)
    j, last = piece(hinge, low), piece(hinge, high)
    if j == last:
        return 0.5 * (on_piece(hinge, j, low) + on_piece(hinge, j, high))
    total, here = 0.0, low
    while j <= last:
        end = high if j == last else hinge[KNOTS + j]
        total += 0.5 * (end - here) * (on_piece(hinge, j, here) + on_piece(hinge, j, end))
        here = end
        j += 1
    return total / (high - low)


@njit(inline="always", error_model="numpy")
def inner(p, s, angle):
    """Returns P after a motion to `angle`."""
    return stops.travel(p, s, angle, False)[0]


@njit(inline="always", error_model="numpy")
def hinge_of(p, s):
    """Returns the part of p that describes h and the offset."""
    return p[HEADER + 2 * (s.size - FIRST_PLAY) :]


@njit(cache=True, error_model="numpy")
def work(p, s, angle, P, delta, distance, loads):
    """Returns the integral of |h(P)| over a motion of sign `delta` from `angle`, where P is given.

    The integral covers the part of the motion beyond P = 0 if the motion `loads`, otherwise the
    part before. P is linear between two angles at which stops begin to slip.
    """
    n, hinge = s.size - FIRST_PLAY, hinge_of(p, s)
    slope = p[0]
    for i in range(n):
        slope += p[HEADER + n + i]
    total, x, Q = 0.0, 0.0, delta * P
    for i in range(n + 1):
        end = distance
        if i < n:
            strain, _ = stop(angle, s[FIRST_PLAY + i], p[HEADER + i])
            end = min(max(p[HEADER + i] - delta * strain, x), distance)
        else:
            slope = p[0]  # the exact value, without the sums' rounding
        if end == math.inf and slope == 0:
            return total
        there, length = Q + slope * (end - x), end - x
        if loads and there > 0:
            if Q < 0:
                length *= there / (there - Q)
            total += abs(mean(hinge, delta * max(Q, 0.0), delta * there)) * length
        elif not loads:
            if there >= 0:
                return total + abs(mean(hinge, delta * Q, 0.0)) * -Q / slope
            total += abs(mean(hinge, delta * Q, delta * there)) * length
        if end == distance:
            return total
        x, Q = end, there
        slope -= p[HEADER + n + i]
    return total


@njit(inline="always", error_model="numpy")
def recoverable(p, s, angle, P):
    """Returns the energy that unloading from `angle` gives back until P = 0."""
    if P == 0:
        return 0.0
    return work(p, s, angle, P, -math.copysign(1.0, P), math.inf, False)


@njit(cache=True, error_model="numpy")
def begin(p, s, angle, torque):
    """Fills s as after the shortest first loading that gives `torque`; returns 1, or NaN."""
    n, hinge = s.size - FIRST_PLAY, hinge_of(p, s)
    elastic, reach = p[0] * (angle - p[1]), 0.0
    for i in range(n):
        reach += p[HEADER + i] * p[HEADER + n + i]
    low, high = elastic - reach, elastic + reach
    least, most, value = hinged(hinge, low), hinged(hinge, high), torque - hinge[OFFSET]
    rounding = START_TOLERANCE * (abs(hinge[OFFSET]) + abs(torque) + abs(least) + abs(most))
    if not least - rounding <= value <= most + rounding:
        return math.nan
    P = elastic  # the torque may differ from h(P) by rounding, maybe by a flat piece of h
    if abs(value - hinged(hinge, elastic)) > rounding:
        P = unhinged(hinge, min(max(value, least), most), elastic)
    return stops.load(p, s, angle, torque, min(max(P, low), high) - elastic, abs(elastic) + reach)


@njit(cache=True, error_model="numpy")
def move(p, s, angle):
    """Returns torque and loss of a motion to another angle; NaN where it is not finite.

    Unloading returns stored energy without a loss. Loading dissipates its work less the increase of
    the stored energy, which is not negative (`HingedStops` has the proof) except for rounding.
    """
    if not math.isfinite(angle):
        return math.nan, 0.0
    P, hinge = inner(p, s, angle), hinge_of(p, s)
    torque = hinge[OFFSET] + hinged(hinge, P)
    delta = 1.0 if angle > s[0] else -1.0
    if not delta * P > 0:
        return torque, 0.0
    before = inner(p, s, s[0])
    loss = work(p, s, s[0], before, delta, abs(angle - s[0]), True) - recoverable(p, s, angle, P)
    if delta * before > 0:
        loss += recoverable(p, s, s[0], before)
    return torque, max(loss, 0.0)


@njit(cache=True, error_model="numpy")
def commit(p, s, angle):
    """Moves the memory on to `angle` and returns the torque; NaN leaves s as it is."""
    if angle == s[0]:
        return s[1]
    torque, loss = move(p, s, angle)
    if math.isnan(torque):
        return torque
    for i in range(s.size - FIRST_PLAY):
        _, s[FIRST_PLAY + i] = stop(angle, s[FIRST_PLAY + i], p[HEADER + i])
    s[0], s[1] = angle, torque
    s[2] += loss
    return torque


@njit(cache=True, error_model="numpy")
def stiffness(p, s, angle, torque, delta):
    """Returns dT/dangle at the end of a motion that goes on with the sign `delta`."""
    P, hinge = inner(p, s, angle), hinge_of(p, s)
    j = piece(hinge, P)
    if delta < 0 and j > 0 and P == hinge[KNOTS + j - 1]:
        j -= 1
    return stops.stiffness(p, s, angle, torque, delta) * hinge[SLOPES + j]


@njit(cache=True, error_model="numpy")
def stored(p, s, angle, torque, loss):
    """Returns the stored energy: that which unloading gives back, and the work of the offset."""
    offset = hinge_of(p, s)[OFFSET]
    return offset * (angle - p[1]) + recoverable(p, s, angle, inner(p, s, angle))


@njit(cache=True)
def is_sound(p):
    """Returns whether the kernels can rely on p, which a user of the engine can overwrite."""
    return 0 <= p[p.size - HINGE + COUNT] <= MOST_KNOTS


@njit(cache=True)
def memory_size(total):
    """Returns how many of these `total` numbers belong to the memory."""
    return stops.memory_size(total - HINGE)
