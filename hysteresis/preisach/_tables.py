"""Computes the parameter vector of the Preisach model: sums over its cells, taken once.

`kernels` describes the vector and reads it.
"""

import numpy as np
from numba import njit

HEADER, SEGMENT, CELL = 3, 7, 8


@njit(cache=True)
def parameter_size(segments):
    """Returns how many numbers the parameter vector of so many segments has."""
    return HEADER + SEGMENT * segments + CELL * (segments * (segments - 1) // 2)


def total_weight(p):
    """Returns the sum of all |weights| of a parameter vector [N·m]."""
    cells = HEADER + SEGMENT * int(p[0])
    return float(np.abs(p[HEADER + 3 : cells : SEGMENT]).sum() + np.abs(p[cells::CELL]).sum())


@njit(cache=True)
def set_parameters(p, levels, density, elastic):
    """Fills the parameter vector p.

    Args:
        p: Result, `parameter_size` numbers.
        levels: Increasing angles [rad], n + 1 numbers.
        density: Rows of weights [N·m], one after the other, n (n + 1) / 2 numbers.
        elastic: Slope of the elastic part in each segment [N·m/rad], n numbers.
    """
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
    """Returns for each cell the sum of its row to the right of it."""
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
