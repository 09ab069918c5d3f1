"""Smooths measured angle-torque records and keeps the tips of the loops."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import isotonic_regression

from ..arrays import Array
from ..errors import InputError
from .loops import Branch, angle_noise, branches, estimate_dead_band, finite_record

BANDWIDTH = 0.15  # bandwidth of the local regression, relative to a branch's range
KNOTS_PER_BANDWIDTH = 8
NEIGHBORS = 5  # least number of samples in a local regression
TIP_EXCESS = 1.5  # standard errors; this keeps the bias of a tip near half the noise or below


def smooth(
    angle: ArrayLike,
    torque: ArrayLike,
    bandwidth: float | None = None,
    dead_band: float | None = None,
) -> tuple[Array, Array]:
    """Smooths a record branch by branch, never across a reversal.

    The angle of a branch becomes monotone by isotonic regression, which turns jitter into dwell and
    keeps monotone angles. The extreme reading at a turn is cut back as far as the angle's
    noise explains it, at most by half the dead band. The torque is a local quadratic regression
    over that angle with tricube weights (Cleveland, JASA 74 (1979) 829), which keeps the torque at
    the ends of a branch and so the tips of a loop. The two branches of a turn estimate its torque
    independently; both are bent, within the bandwidth, to meet in the mean. All samples of a dwell
    get one torque.

    Args:
        angle: Joint angles [rad], shape (n,), n >= 3.
        torque: Torques [N·m], shape (n,).
        bandwidth: Distance at which a neighbor's weight has fallen to zero [rad], > 0; None takes
            15 % of each branch.
        dead_band: Dead band of `reversals` [rad].

    Returns:
        Angle [rad] and torque [N·m], shape (n,) each, with one value for each sample of the record.

    Raises:
        InputError: The series are not a record, or the bandwidth is not above 0.
    """
    if bandwidth is not None and not (math.isfinite(bandwidth) and bandwidth > 0):
        raise InputError(f"bandwidth is {bandwidth}: give a finite number above 0 (rad)")
    angle, torque = finite_record(angle, torque)
    dead_band = estimate_dead_band(angle) if dead_band is None else dead_band
    pieces = branches(angle, torque, dead_band)
    angles = _monotone_angles(pieces, angle_noise(angle), dead_band / 2)
    spans = [float(np.ptp(values)) for values in angles]
    widths = [min(bandwidth or BANDWIDTH * span, span) for span in spans]
    torques = [
        _local_regression(values, piece.torque, width)
        for values, piece, width in zip(angles, pieces, widths, strict=True)
    ]
    for i in range(1, len(pieces)):
        half_gap = (torques[i][0] - torques[i - 1][-1]) / 2
        for j, sign in ((i - 1, 1), (i, -1)):
            distance = np.abs(angles[j] - angles[i][0])
            torques[j] += sign * half_gap * np.clip(1 - distance / widths[j], 0, 1)
    return _joined(angles), _joined(torques)


def resample(branch: Branch, samples: int) -> tuple[Array, Array]:
    """Interpolates a branch linearly on a uniform grid of angles, in its direction.

    Jitter is removed as in `smooth`, and a dwell counts with its mean torque.

    Args:
        branch: Branch of a record, as `branches` returns them.
        samples: Number of angles, >= 2.

    Returns:
        Angle [rad] and torque [N·m], shape (samples,) each.

    Raises:
        InputError: `samples` is below 2.
    """
    if samples < 2:
        raise InputError(f"samples is {samples}: use at least 2")
    angle = _monotone(branch)
    known, means, _, _ = _distinct(angle, branch.torque)
    grid = np.linspace(angle[0], angle[-1], samples)
    return grid, np.interp(grid, known, means)


def _monotone(branch: Branch) -> Array:
    return isotonic_regression(branch.angle, increasing=branch.direction > 0).x


def _monotone_angles(pieces: list[Branch], noise: float, largest_cut: float) -> list[Array]:
    fitted = [_monotone(piece) for piece in pieces]
    for piece, (before, after) in zip(pieces, pairwise(fitted), strict=False):
        sign = piece.direction
        tip = sign * _tip(sign * np.concatenate([before, after[1:]]), noise, largest_cut)
        cut = np.minimum if sign > 0 else np.maximum
        cut(before, tip, out=before)
        cut(after, tip, out=after)
    return fitted


def _tip(fitted: Array, noise: float, largest_cut: float) -> float:
    """Returns the lowest level at which noise explains the mean excess of the angles above it."""
    levels = np.sort(fitted[fitted >= fitted.max() - largest_cut])[::-1]
    count = np.arange(1, levels.size + 1)
    excess = np.cumsum(levels) / count - levels
    explained = excess * np.sqrt(count) <= TIP_EXCESS * noise
    return float(levels[np.flatnonzero(explained)[-1]])


def _distinct(angle: Array, torque: Array) -> tuple[Array, Array, Array, NDArray[np.intp]]:
    """Returns distinct angles, ascending, their mean torques and counts, and the map to them."""
    distinct, where, counts = np.unique(angle, return_inverse=True, return_counts=True)
    return distinct, np.bincount(where, torque) / counts, counts.astype(np.float64), where


def _local_regression(angle: Array, torque: Array, bandwidth: float) -> Array:
    known, means, counts, where = _distinct(angle, torque)
    if known.size < NEIGHBORS:
        return means[where]
    # Long branches are fitted at knots; a cubic spline between them adds no error worth the time.
    knots = math.ceil(KNOTS_PER_BANDWIDTH * (known[-1] - known[0]) / bandwidth) + 1
    at = known if known.size <= knots else np.linspace(known[0], known[-1], knots)
    fitted = np.array([_local_value(known, means, counts, x, bandwidth) for x in at])
    return (fitted if at is known else CubicSpline(at, fitted)(known))[where]


def _local_value(known: Array, means: Array, counts: Array, x: float, bandwidth: float) -> float:
    first, last = np.searchsorted(known, [x - bandwidth, x + bandwidth])
    if last - first < NEIGHBORS:
        middle = int(np.searchsorted(known, x))
        first, last = max(middle - NEIGHBORS, 0), middle + NEIGHBORS
        distances = np.sort(np.abs(known[first:last] - x))
        bandwidth = max(bandwidth, distances[NEIGHBORS - 1])
    u = (known[first:last] - x) / bandwidth
    weight = np.sqrt(counts[first:last] * np.clip(1 - np.abs(u) ** 3, 0, 1) ** 3)
    terms = np.vander(u, 3, increasing=True) * weight[:, None]
    return float(np.linalg.lstsq(terms, means[first:last] * weight)[0][0])


def _joined(pieces: list[Array]) -> Array:
    return np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
