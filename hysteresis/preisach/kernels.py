"""Kernels of the Preisach model: plain functions over scalars and arrays, compiled by numba.

Memory after the common three numbers: torque of the relays [N·m], number k of turning points, loss
on the present branch [J], then records (angle clipped to the levels [rad], torque of the relays
there [N·m]). Record 0 is the lowest level with every relay down; record i is a maximum for odd i, a
minimum for even i. The present branch leaves record k, and rises for even k and falls for odd k.

Parameters (`Preisach.parameter_vector`): number n of segments, lowest and highest level; n rows

    level i, width h, 1/h, weight w_ii on the diagonal, elastic torque at level i, slope, energy

and a row of eight for each cell (i, j), j < i, up-switching segment i, down-switching segment j:

    weight w_ij, then over the cells between: R = sum of row i, C = sum of column j, sum N of the
    triangle, loss of row, column and triangle, moment of the triangle

In a cell, with du = x - level i, u = du / h_i, db = level j+1 - y and b = db / h_j, these numbers
give the exact integrals over the triangle y <= down-switching <= up-switching <= x of a piecewise
uniform density: `swept` and `moment`.
"""

import math

import numpy as np
from numba import njit

HEADER, SEGMENT, CELL = 3, 7, 8  # how many numbers p has first, for a segment, for a cell
CAPACITY = 64  # even: branch 64 rises, so that `walk` checks only whether a fall passes its base
RELAYS, COUNT, BRANCH_LOSS, RECORDS = 3, 4, 5, 6
MEMORY_SIZE = RECORDS + 2 * (CAPACITY + 1)
LEVEL, WIDTH, PER_WIDTH, DIAGONAL, TORQUE, SLOPE, ENERGY = range(SEGMENT)
OWN, ROW, COLUMN, TRIANGLE, ROW_LOSS, COLUMN_LOSS, TRIANGLE_LOSS, TRIANGLE_MOMENT = range(CELL)


@njit(cache=True)
def parameter_size(segments):
    """Returns the size of the parameter vector of a number of segments."""
    return HEADER + SEGMENT * segments + CELL * (segments * (segments - 1) // 2)


def total_weight(p):
    """Returns the sum of all |weights| of a parameter vector [N·m]."""
    cells = HEADER + SEGMENT * int(p[0])
    return float(np.abs(p[HEADER + 3 : cells : SEGMENT]).sum() + np.abs(p[cells::CELL]).sum())


@njit(cache=True)
def set_parameters(p, levels, density, elastic):
    """Fills p from levels, rows of the density end to end, and elastic slopes of n segments."""
    n = elastic.size
    weight = np.zeros((n, n))
    for i in range(n):
        weight[i, : i + 1] = density[i * (i + 1) // 2 : (i + 1) * (i + 2) // 2]
    p[0], p[1], p[2] = n, levels[0], levels[n]
    torque = energy = 0.0
    for i in range(n):
        width = levels[i + 1] - levels[i]
        row = p[HEADER + SEGMENT * i : HEADER + SEGMENT * (i + 1)]
        row[0], row[1], row[2], row[3] = levels[i], width, 1 / width, weight[i, i]
        row[4], row[5], row[6] = torque, elastic[i], energy
        energy += (torque + elastic[i] * width / 2) * width
        torque += elastic[i] * width
    set_cells(p, levels, weight)


@njit(cache=True)
def set_cells(p, levels, weight):
    """Fills the rows of the cells (i, j), j < i."""
    n = weight.shape[0]
    start, end = levels[:-1], levels[1:]
    middle = (start + end) / 2
    apart, row_loss, column_loss = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    loss, moment = np.zeros((n, n)), np.zeros((n, n))
    for i in range(n):
        loss[i, i] = weight[i, i] * (end[i] - start[i]) / 6
        moment[i, i] = weight[i, i] * (middle[i] - levels[0])
        for j in range(i):
            apart[i, j] = weight[i, j]
            row_loss[i, j] = weight[i, j] * (start[i] - middle[j]) / 2
            column_loss[i, j] = weight[i, j] * (middle[i] - end[j]) / 2
            loss[i, j] = weight[i, j] * (middle[i] - middle[j]) / 2
            moment[i, j] = weight[i, j] * ((middle[i] + middle[j]) / 2 - levels[0])
    row, column, triangle = sum_row(apart), sum_column(apart), sum_column(sum_row(weight))
    row_loss, column_loss = sum_row(row_loss), sum_column(column_loss)
    loss, moment = sum_column(sum_row(loss)), sum_column(sum_row(moment))
    at = HEADER + SEGMENT * n
    for i in range(n):
        for j in range(i):
            p[at], p[at + 1], p[at + 2] = apart[i, j], row[i, j], column[i, j]
            p[at + 3], p[at + 4], p[at + 5] = triangle[i, j], row_loss[i, j], column_loss[i, j]
            p[at + 6], p[at + 7] = loss[i, j], moment[i, j]
            at += CELL


@njit(cache=True)
def sum_row(values):
    """Returns for each cell the sum of the cells to the right in its row."""
    sums = np.zeros_like(values)
    for j in range(values.shape[1] - 2, -1, -1):
        sums[:, j] = sums[:, j + 1] + values[:, j + 1]
    return sums


@njit(cache=True)
def sum_column(values):
    """Returns for each cell the sum of its column in the rows of smaller index."""
    sums = np.zeros_like(values)
    for i in range(1, values.shape[0]):
        sums[i] = sums[i - 1] + values[i - 1]
    return sums


@njit(inline="always", error_model="numpy")
def segment(p, x):
    """Returns the last segment, 0 to n-1, that does not begin above x."""
    low, high = 0, int(p[0])
    while high - low > 1:
        middle = (low + high) // 2
        if x >= p[HEADER + SEGMENT * middle]:
            low = middle
        else:
            high = middle
    return low


@njit(inline="always", error_model="numpy")
def cell_row(p, i, j):
    """Returns where the row of cell (i, j), j < i, begins."""
    return HEADER + SEGMENT * int(p[0]) + CELL * (i * (i - 1) // 2 + j)


@njit(inline="always", error_model="numpy")
def clipped(p, angle):
    """Returns the nearest angle within the levels; beyond them no relay switches."""
    return min(max(angle, p[1]), p[2])


@njit(inline="always", error_model="numpy")
def turning_points(s):
    """Returns the number of turning points, within the capacity even if a user overwrote s."""
    count = s[COUNT]
    if count >= CAPACITY:
        return CAPACITY
    return int(count) if count > 0 else 0


@njit(cache=True, error_model="numpy")
def swept(p, x, y):
    """Returns weight [N·m] and loss [J] of the relays that a motion between two angles switches.

    The weight is the Everett function E(max, min); the loss is the integral of the density times
    (up-switching minus down-switching angle) / 2 over the same triangle.
    """
    if x < y:
        x, y = y, x
    i, j = segment(p, x), segment(p, y)
    a, c = HEADER + SEGMENT * i, HEADER + SEGMENT * j
    if i <= j:
        # In one triangle on the diagonal the mean of (up - down) / 2 is a sixth of the side.
        u = (x - y) * p[a + PER_WIDTH]
        weight = p[a + DIAGONAL] * u * u
        return weight, weight * (x - y) / 6
    r = cell_row(p, i, j)
    du, db = x - p[a + LEVEL], p[c + WIDTH] - (y - p[c + LEVEL])
    u, b = du * p[a + PER_WIDTH], db * p[c + PER_WIDTH]
    corner, upper, lower = u * b * p[r + OWN], u * u * p[a + DIAGONAL], b * b * p[c + DIAGONAL]
    weight = p[r + TRIANGLE] + u * p[r + ROW] + b * p[r + COLUMN] + corner + upper + lower
    loss = (
        p[r + TRIANGLE_LOSS]
        + u * (p[r + ROW_LOSS] + 0.25 * du * p[r + ROW])
        + b * (p[r + COLUMN_LOSS] + 0.25 * db * p[r + COLUMN])
        + 0.5 * corner * (x - y - 0.5 * (du + db))
        + (upper * du + lower * db) / 6
    )
    return weight, loss


@njit(cache=True, error_model="numpy")
def moment(p, x, y):
    """Returns the integral of the density times (middle of the relay's loop - lowest level) [J]."""
    if x < y:
        x, y = y, x
    i, j = segment(p, x), segment(p, y)
    a, c = HEADER + SEGMENT * i, HEADER + SEGMENT * j
    x, y = x - p[1], y - p[1]
    top, bottom = p[a + LEVEL] - p[1], p[c + LEVEL] - p[1] + p[c + WIDTH]
    if i <= j:
        u = (x - y) * p[a + PER_WIDTH]
        return p[a + DIAGONAL] * u * u * 0.5 * (x + y)
    r = cell_row(p, i, j)
    du, db = x - top, bottom - y
    u, b = du * p[a + PER_WIDTH], db * p[c + PER_WIDTH]
    return (
        p[r + TRIANGLE_MOMENT]
        + u * ((top + 0.25 * du) * p[r + ROW] - p[r + ROW_LOSS])
        + b * ((bottom - 0.25 * db) * p[r + COLUMN] + p[r + COLUMN_LOSS])
        + u * b * p[r + OWN] * 0.5 * (top + bottom + 0.5 * (du - db))
        + u * u * p[a + DIAGONAL] * (top + 0.5 * du)
        + b * b * p[c + DIAGONAL] * (bottom - 0.5 * db)
    )


@njit(inline="always", error_model="numpy")
def elastic(p, angle):
    """Returns torque [N·m] and energy [J] of the elastic part, from 0 at the lowest level."""
    a = HEADER + SEGMENT * segment(p, angle)
    d, slope = angle - p[a + LEVEL], p[a + SLOPE]
    torque = p[a + TORQUE] + slope * d
    return torque, p[a + ENERGY] + 0.5 * d * (p[a + TORQUE] + torque)


@njit(cache=True, error_model="numpy")
def walk(p, s, angle):
    """Computes a motion to an angle and leaves the memory as it is.

    Returns (k, relays, lost, on_branch): the branch k on which the motion ends (turning points + 1
    for a new branch, which leaves s[0]), the torque of the relays, the energy dissipated on the
    way, and the energy dissipated on branch k since its record. The innermost branch counts no loss
    if the stack is full.
    """
    x, k = clipped(p, angle), turning_points(s)
    if angle == s[0]:
        return k, s[RELAYS], 0.0, s[BRANCH_LOSS]
    rises = angle > s[0]
    base, relays, on_branch = s[RECORDS + 2 * k], s[RECORDS + 2 * k + 1], s[BRANCH_LOSS]
    if rises != (k % 2 == 0):
        # The motion turns and opens a branch, or goes back along the last branch of a full stack.
        if k < CAPACITY:
            k, base, relays, on_branch = k + 1, clipped(p, s[0]), s[RELAYS], 0.0
        elif x > base:
            return k, relays - swept(p, x, base)[0], 0.0, 0.0
        else:
            k -= 1
            bound = base
            base, relays = s[RECORDS + 2 * k], s[RECORDS + 2 * k + 1]
            on_branch = swept(p, base, bound)[1]
    lost = 0.0
    while k > 0:
        bound = s[RECORDS + 2 * (k - 1)]
        if x < bound if rises else x > bound:
            break
        # The loop between base and bound closes. A loop has two turning points, a minimum and a
        # maximum, so two records are removed, and the motion continues the branch before the loop.
        lost += swept(p, bound, base)[1] - on_branch
        k -= 2
        base, relays = s[RECORDS + 2 * max(k, 0)], s[RECORDS + 2 * max(k, 0) + 1]
        on_branch = swept(p, bound, base)[1]
    k = max(k, 0)  # k is -1 after a fall to the lowest level, which is record 0 itself
    weight, loss = swept(p, x, base)
    if k == CAPACITY:
        loss = 0.0
    # The sum begins at the record, not at s, so that rounding of closed loops does not add up.
    relays += weight if k % 2 else -weight
    return k, relays, lost + loss - on_branch, loss


@njit(inline="always", error_model="numpy")
def total(p, angle, relays):
    """Returns the torque at an angle, NaN where it is not finite."""
    torque = relays + elastic(p, angle)[0]
    return torque if math.isfinite(torque) else math.nan


@njit(cache=True, error_model="numpy")
def begin(p, s, angle, torque):
    """Starts a motion as if the angle had come up from below the lowest level."""
    s[:] = 0.0
    offset = torque - elastic(p, angle)[0]
    if not (math.isfinite(angle) and math.isfinite(offset)):
        return math.nan
    weight, loss = swept(p, clipped(p, angle), p[1])
    s[0], s[1] = angle, torque
    s[RECORDS], s[RECORDS + 1] = p[1], offset + weight
    s[RELAYS], s[BRANCH_LOSS] = s[RECORDS + 1] - weight, loss
    return math.inf


@njit(cache=True, error_model="numpy")
def move(p, s, angle):
    """Returns (torque, loss) after a monotone motion from the memory to another angle."""
    if not math.isfinite(angle):
        return math.nan, 0.0
    _, relays, lost, _ = walk(p, s, angle)
    return total(p, angle, relays), lost


@njit(cache=True, error_model="numpy")
def commit(p, s, angle):
    """Moves the memory on to `angle` and returns the torque; NaN leaves s as it is."""
    if angle == s[0]:
        return s[1]
    if not math.isfinite(angle):
        return math.nan
    k, relays, lost, on_branch = walk(p, s, angle)
    torque = total(p, angle, relays)
    if math.isnan(torque):
        return torque
    if k == turning_points(s) + 1:
        s[RECORDS + 2 * k] = clipped(p, s[0])
        s[RECORDS + 2 * k + 1] = s[RELAYS]
    s[0], s[1] = angle, torque
    s[2] += lost
    s[RELAYS], s[COUNT], s[BRANCH_LOSS] = relays, k, on_branch
    return torque


@njit(cache=True, error_model="numpy")
def stiffness(p, s, angle, torque, delta):
    """Returns dT/dangle after a motion to `angle` if it goes on with sign `delta`."""
    k, _, _, _ = walk(p, s, angle)
    rises = delta > 0
    i = segment(p, angle)
    # At a level the motion enters the segment on its own side.
    if not rises and i > 0 and angle == p[HEADER + SEGMENT * i]:
        i -= 1
    a = HEADER + SEGMENT * i
    slope = p[a + SLOPE]
    if angle >= p[2] if rises else angle > p[2]:
        return slope
    if angle < p[1] if rises else angle <= p[1]:
        return slope
    if rises != (k % 2 == 0) and k < CAPACITY:  # just after a turn no relay switches
        return slope
    base = s[RECORDS + 2 * k] if k <= turning_points(s) else clipped(p, s[0])
    j = segment(p, base)
    c = HEADER + SEGMENT * j
    if i == j:
        return slope - 2 * p[a + DIAGONAL] * abs(angle - base) * p[a + PER_WIDTH] ** 2
    if i > j:
        r = cell_row(p, i, j)
        u = (angle - p[a + LEVEL]) * p[a + PER_WIDTH]
        b = 1 - (base - p[c + LEVEL]) * p[c + PER_WIDTH]
        inner, along = p[r + ROW] + 2 * u * p[a + DIAGONAL], b * p[r + OWN]
    else:
        r = cell_row(p, j, i)
        u = (base - p[c + LEVEL]) * p[c + PER_WIDTH]
        b = 1 - (angle - p[a + LEVEL]) * p[a + PER_WIDTH]
        inner, along = p[r + COLUMN] + 2 * b * p[a + DIAGONAL], u * p[r + OWN]
    return slope - (inner + along) * p[a + PER_WIDTH]


@njit(cache=True, error_model="numpy")
def stored(p, s, angle, torque, loss):
    """Returns the energy stored at the end of a motion to `angle`; `Preisach` has the proof."""
    k, relays, _, _ = walk(p, s, angle)
    count = turning_points(s)
    turned, last = 0.0, s[RECORDS]
    for i in range(1, k + 1):
        turn = s[RECORDS + 2 * i] if i <= count else clipped(p, s[0])
        part = moment(p, turn, last)
        turned += part if i % 2 else -part
        last = turn
    x = clipped(p, angle)
    part = moment(p, x, last)
    total = relays * (angle - p[1]) + elastic(p, angle)[1] + turned + (-part if k % 2 else part)
    if k == CAPACITY:
        total += swept(p, x, last)[1]
    return total


@njit(cache=True, error_model="numpy")
def dissipated(p, s, angle, torque, loss):
    """Returns the energy dissipated from the start to the end of a motion to `angle`."""
    return s[2] + loss


@njit(cache=True)
def is_sound(p):
    """Returns whether the kernels can rely on p, which a user of the engine can overwrite."""
    return parameter_size(p[0]) == p.size


@njit(cache=True)
def memory_size(total):
    """Returns how many of these `total` numbers belong to the memory."""
    return MEMORY_SIZE
