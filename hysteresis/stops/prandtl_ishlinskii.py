"""Kernels of the Prandtl-Ishlinskii model, several of which hinged stops use too.

They compute the stop form only, T = K (theta - rest) + sum w_i E_i; `PrandtlIshlinskii` rewrites
the play form. Parameters p = [K, rest, r_1 ... r_n, w_1 ... w_n], thresholds r rising.

The memory s = [angle, torque, loss, F_1 ... F_n] holds the play F of each element, the angle at
which the stop E = theta - F is zero. F follows from the turning points alone, F = max(F, theta - r)
upwards and min(F, theta + r) downwards, so neither the number of samples nor a closed excursion
changes F, not even by rounding.
"""

import math

from numba import njit

HEADER = 2  # numbers in p before the thresholds
FIRST_PLAY = 3  # numbers in s before the plays
START_TOLERANCE = 1e-12  # rounding of a saturated torque, relative to the sum of all |torques|


@njit(inline="always", error_model="numpy")
def stop(angle: float, play: float, threshold: float) -> tuple[float, float]:
    """Returns E and F of an element after a motion to `angle`; |E| never exceeds the threshold."""
    low, high = angle - threshold, angle + threshold
    if play <= low:
        return threshold, low
    if play >= high:
        return -threshold, high
    return angle - play, play


@njit(cache=True, error_model="numpy")
def first_motion(p, n, wanted, tolerance):
    """Returns the smallest x with phi(x) = sum w_i clip(x, -r_i, r_i) = wanted, or NaN.

    phi is odd and linear between thresholds: x lies below the first one with |phi| >= |wanted|.
    """
    slope = 0.0
    for i in range(n):
        slope += p[HEADER + n + i]
    x = phi = 0.0
    for i in range(n):
        reach = p[HEADER + i] - x
        end = phi + slope * reach
        if abs(end) >= abs(wanted) - tolerance:
            more = (math.copysign(wanted, end) - phi) / slope if slope != 0 else 0.0
            return math.copysign(x + min(more, reach), wanted * end)
        x, phi = p[HEADER + i], end
        slope -= p[HEADER + n + i]
    return math.nan


@njit(cache=True, error_model="numpy")
def load(p, s, angle, torque, wanted, scale):
    """Fills s as after the shortest first loading whose stops give `wanted`; returns 1, or NaN.

    The torque is that of the whole model, and `scale` the sum of all |torques| of its parts.
    """
    n = s.size - FIRST_PLAY
    x = first_motion(p, n, wanted, START_TOLERANCE * scale)
    if math.isnan(x):
        return math.nan
    s[0], s[1], s[2] = angle, torque, 0.0
    for i in range(n):
        s[FIRST_PLAY + i] = angle - min(max(x, -p[HEADER + i]), p[HEADER + i])
    return 1.0


@njit(cache=True, error_model="numpy")
def begin(p, s, angle, torque):
    """Fills s as after a first loading that gives `torque`; returns 1, or NaN if impossible.

    Loading by x from the angle where all stops are at zero gives K (angle - rest) + phi(x).
    """
    n = s.size - FIRST_PLAY
    elastic = p[0] * (angle - p[1])
    scale = abs(elastic) + abs(torque)
    for i in range(n):
        scale += abs(p[HEADER + n + i]) * p[HEADER + i]
    return load(p, s, angle, torque, torque - elastic, scale)


@njit(inline="always", error_model="numpy")
def travel(p, s, angle, keep):
    """Returns torque and loss of a motion to `angle`; `keep` stores the new plays in s."""
    n = s.size - FIRST_PLAY
    torque, loss = p[0] * (angle - p[1]), 0.0
    for i in range(n):
        threshold, weight = p[HEADER + i], p[HEADER + n + i]
        strain, play = stop(angle, s[FIRST_PLAY + i], threshold)
        torque += weight * strain
        loss += weight * threshold * abs(play - s[FIRST_PLAY + i])
        if keep:
            s[FIRST_PLAY + i] = play
    return torque, loss


@njit(cache=True, error_model="numpy")
def move(p, s, angle):
    """Returns (torque, loss) after a motion to another angle; NaN where it is not finite."""
    if not math.isfinite(angle):
        return math.nan, 0.0
    return travel(p, s, angle, False)


@njit(cache=True, error_model="numpy")
def commit(p, s, angle):
    """Moves the memory on to `angle` and returns the torque; NaN leaves s as it is."""
    if angle == s[0]:
        return s[1]
    if not math.isfinite(angle):
        return math.nan
    torque, loss = travel(p, s, angle, True)
    s[0], s[1] = angle, torque
    s[2] += loss
    return torque


@njit(cache=True, error_model="numpy")
def stiffness(p, s, angle, torque, delta):
    """Returns dT/dangle at the end of a motion that goes on with the sign `delta`."""
    n = s.size - FIRST_PLAY
    slope = p[0]
    for i in range(n):
        strain, _ = stop(angle, s[FIRST_PLAY + i], p[HEADER + i])
        if delta * strain < p[HEADER + i]:
            slope += p[HEADER + n + i]
    return slope


@njit(cache=True, error_model="numpy")
def stored(p, s, angle, torque, loss):
    """Returns the stored energy; a stop is a spring of stiffness w in series with a slider."""
    n = s.size - FIRST_PLAY
    twice = p[0] * (angle - p[1]) ** 2
    for i in range(n):
        strain, _ = stop(angle, s[FIRST_PLAY + i], p[HEADER + i])
        twice += p[HEADER + n + i] * strain**2
    return 0.5 * twice


@njit(cache=True, error_model="numpy")
def dissipated(p, s, angle, torque, loss):
    """Returns the energy that the sliders have dissipated."""
    return s[2] + loss


@njit(cache=True)
def is_sound(p):
    """Returns whether the kernels can rely on p, which a user of the engine can overwrite."""
    return True


@njit(cache=True)
def memory_size(total):
    """Returns how many of these `total` numbers belong to the memory."""
    return FIRST_PLAY + (total - FIRST_PLAY - HEADER) // 3
