"""Models of many weights: Prandtl-Ishlinskii, Preisach, and hinged stops.

The fits take first-order curves, of which those with role "fit" are used;
`response(angle, initial_torque)` of the returned model predicts a curve.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag
from scipy.optimize import least_squares, nnls

from ...arrays import Array
from ...checks import at_least
from ...errors import InputError
from ...hysteresis.preisach.model import Preisach
from ...hysteresis.protocol import HysteresisModel, Numbers
from ...hysteresis.stops import HingedStops, PrandtlIshlinskii
from ..data.curves import Curve, noise_floor
from .parameters import FREE, Constraints, bounded_least_squares
from .search import common_start, usable
from .tangent import beside

LEAST_NOISE = 1e-9  # least noise over the peak, so that data without noise have one solution too
SLOPE_STEP = 1.0  # expected difference of neighbors, in peak torque over the range of the levels
DENSITY_STEP = 10.0  # expected difference of neighbors, in peak torque per cell
MOST_NUMBERS = 25_000_000  # largest size of a matrix, of which there are five at a time: 1 GB
MOST_PIVOTS = 100  # largest number of pivots per unknown; fewer than 3 are usual
THRESHOLDS = (0.03, 0.85)  # smallest and largest threshold over the longest way out
KNOTS = 9
WEIGHT_SPREAD = 1.0  # expected spread of the logarithms of the weights
LEAST_SLOPE = 0.02  # least slope of h, so that a torque determines where a motion begins
SMALLEST, LARGEST = -9.0, 4.0  # logarithm of a weight, relative to the others
STALLED = 1e-4  # relative change of cost or point that ends the search
MOST_STEPS = 40


def fit_preisach(
    curves: Sequence[Curve], levels: int | Sequence[float] = 20, constraints: Constraints = FREE
) -> Preisach:
    """Fits a dissipative Preisach model to first-order curves, by non-negative least squares.

    Torque is linear in the density, which must not be negative, in the elastic slopes, which may,
    and in the torque at which each curve begins: the best model follows without a search. Numbers
    that the curves leave open, such as relays between two turns, become smooth: differences between
    neighbors in density and in slope count too, in proportion to the noise of the torque.

    Args:
        curves: Any number of curves from the lowest angle up to a turn and back.
        levels: The levels [rad], or how many segments to make: one below the lowest angle, the
            others up to the highest. Without a level below the lowest angle, every curve of the
            model comes back to its first torque.
        constraints: Weights and slopes that are fixed or bounded.
    """
    curves = usable(curves)
    low, high = curves.angle_range
    grid = _levels(low, high, levels)
    size = np.size(grid) - 1
    cells = size * (size + 1) // 2
    rigid = _rows(np.zeros(cells))
    width = np.diff(Preisach(levels=grid, density=rigid).levels)
    if grid[0] >= high or grid[-1] <= low:
        raise InputError(
            f"the levels go from {grid[0]:.6g} to {grid[-1]:.6g} rad and the curves from "
            f"{low:.6g} to {high:.6g}: give levels among the curves' angles"
        )
    relays = [Preisach(levels=grid, density=_rows(unit)) for unit in np.eye(cells)]
    springs = [Preisach(levels=grid, density=rigid, elastic=unit) for unit in np.eye(size).tolist()]
    noise = max(_noise(curves) / curves.peak, LEAST_NOISE)
    slope_rule = noise / SLOPE_STEP * np.ptp(grid) * np.diff(np.eye(size), axis=0)
    density_rule = noise / DENSITY_STEP * cells * _differences(width / width.mean())
    places = [f"density[{i}][{j}]" for i in range(size) for j in range(i + 1)]
    names = [f"elastic[{i}]" for i in range(size)] + places
    _, slopes, weights = _least_squares(
        curves,
        responses(curves, springs),
        responses(curves, relays),
        np.asarray(block_diag(slope_rule, density_rule)),
        constraints.ends_of(names) if constraints else None,
    )
    return Preisach(levels=grid, density=_rows(weights), elastic=slopes.tolist())


def fit_prandtl_ishlinskii(
    curves: Sequence[Curve], thresholds: int | Sequence[float] = 20, constraints: Constraints = FREE
) -> PrandtlIshlinskii:
    """Fits a dissipative Prandtl-Ishlinskii model of stops by non-negative least squares.

    Torque is linear in the weights, which must not be negative, in the stiffness, which may, and
    in the torque at which each curve begins. All stops are at zero at the beginning, as before any
    motion; with the rest angle, the elastic part gives the mean first torque of the curves.

    Args:
        curves: Curves that all begin at one angle.
        thresholds: The thresholds [rad], or how many to spread evenly over the longest way out.
        constraints: Weights and stiffness that are fixed or bounded; a rest angle is not.
    """
    curves = usable(curves)
    start = common_start(curves)
    reach = max(float(np.abs(curve.angle - curve.angle[0]).max()) for curve in curves)
    grid = _thresholds(reach, thresholds)
    if not grid[0] < reach:
        raise InputError(
            f"the smallest threshold is {grid[0]:.6g} rad, but the curves go no further than "
            f"{reach:.6g} rad: no slider would ever slip; give smaller thresholds"
        )
    sliders = [PrandtlIshlinskii(stiffness=0, thresholds=[r], weights=[1]) for r in grid]
    spring = np.concatenate([curve.angle - curve.angle[0] for curve in curves])[:, None]
    names = ["stiffness"] + [f"weights[{i}]" for i in range(len(sliders))]
    ends = constraints.ends_of(names) if constraints else None
    columns = spring, responses(curves, sliders)
    offsets, slopes, weights = _least_squares(curves, *columns, ends=ends)
    stiffness = float(slopes[0])
    first_torque = float(np.mean(offsets))
    return PrandtlIshlinskii(
        stiffness=stiffness,
        thresholds=grid,
        weights=weights.tolist(),
        rest_angle=start - first_torque / stiffness if stiffness else start,
    )


def _levels(low: float, high: float, levels: int | Sequence[float]) -> Sequence[float]:
    if not isinstance(levels, (int, np.integer)):
        return levels
    at_least("levels", int(levels), 2)
    return np.linspace(low - (high - low) / (levels - 1), high, levels + 1).tolist()


def _thresholds(reach: float, thresholds: int | Sequence[float]) -> Numbers:
    if isinstance(thresholds, (int, np.integer)):
        at_least("thresholds", int(thresholds), 1)
        return (reach * np.arange(1, thresholds + 1) / (thresholds + 1)).tolist()
    weights = [1.0] * np.size(thresholds)
    return PrandtlIshlinskii(stiffness=0, thresholds=thresholds, weights=weights).thresholds


def _noise(curves: Sequence[Curve]) -> float:
    """Estimates the torque's noise [N·m]; the models are quadratic almost everywhere."""
    third = np.concatenate([np.diff(curve.torque, 3) for curve in curves])
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20)) if third.size else 0.0


def responses(curves: Sequence[Curve], models: Sequence[HysteresisModel]) -> Array:
    """Returns the change of torque along all curves, a column for each model."""
    samples = sum(curve.angle.size for curve in curves)
    if samples * len(models) > MOST_NUMBERS:
        raise InputError(
            f"{samples:,} samples and {len(models):,} weights are more than memory should hold: "
            "give fewer levels or thresholds, or thin the curves "
            "(activesuit.identification.data.parts.thinned)"
        )
    columns = [[model.response(curve.angle) for curve in curves] for model in models]
    return np.stack([np.concatenate(column) for column in columns], axis=1)


def _least_squares(
    curves: Sequence[Curve],
    free: Array,
    positive: Array,
    rules: ArrayLike = (),
    ends: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Minimizes |offset of each curve + free x + positive y - torque|^2 + |rules (x, y)|^2.

    The columns `free` and `positive` have the shape (samples, n). `rules` are rows that draw
    numbers together, and `ends` the bounds of x and y, shape (2, n). Returns offsets, x and y >= 0.
    """
    begins = np.repeat(np.eye(len(curves)), [curve.angle.size for curve in curves], axis=0)
    rows = np.reshape(rules, (-1, free.shape[1] + positive.shape[1]))
    design = np.hstack([begins, free, positive])
    design = np.vstack([design, np.pad(rows, ((0, 0), (len(curves), 0)))])
    target = np.concatenate([*[curve.torque for curve in curves], np.zeros(len(rows))])
    if ends is not None:
        low, high = np.pad(ends, ((0, 0), (len(curves), 0)), constant_values=np.inf)
        low[: len(curves)] = -np.inf
        low[-positive.shape[1] :] = np.maximum(low[-positive.shape[1] :], 0)
        both = np.asarray(np.linalg.qr(np.column_stack([design, target]), mode="r"))
        x, _ = bounded_least_squares(both[:, :-1], both[:, -1], low, high)
        offsets, slopes, weights = np.split(x, [len(curves), len(curves) + free.shape[1]])
        return offsets, slopes, weights
    # Free columns are projected out; the triangle is the same problem in fewer rows.
    first, last = np.split(design, [len(curves) + free.shape[1]], axis=1)
    basis, triangle = np.linalg.qr(first)
    both = np.column_stack([last, target])
    both = np.asarray(np.linalg.qr(beside(basis, both), mode="r"))
    y, _ = nnls(both[:, :-1], both[:, -1], maxiter=MOST_PIVOTS * positive.shape[1])
    x = np.linalg.solve(triangle, basis.T @ (target - last @ y))
    return x[: len(curves)], x[len(curves) :], y


def _rows(weights: Array) -> list[list[float]]:
    """Cuts the weights of all cells into rows of one, two, three ..."""
    ends = np.cumsum(np.arange(1, math.isqrt(2 * weights.size)))
    return [row.tolist() for row in np.split(weights, ends)]


def _differences(width: Array) -> Array:
    """Returns the matrix that takes weights to differences of density between neighbor cells."""
    i, j = np.tril_indices(width.size)
    area = width[i] * width[j] * np.where(i == j, 0.5, 1.0)
    number = np.full((width.size + 1, width.size + 1), -1)
    number[i, j] = np.arange(i.size)
    pairs = [
        (cell, neighbor)
        for cell in range(i.size)
        for neighbor in (number[i[cell] + 1, j[cell]], number[i[cell], j[cell] + 1])
        if neighbor >= 0
    ]
    matrix = np.zeros((len(pairs), i.size))
    for row, (cell, neighbor) in zip(matrix, pairs, strict=True):
        row[cell], row[neighbor] = 1 / area[cell], -1 / area[neighbor]
    return matrix


def fit_hinged_stops(curves: Sequence[Curve], thresholds: int = 12) -> HingedStops:
    """Fits hinged stops, which are dissipative whatever their parameters, by variable projection.

    At fixed weights of spring and stops torque is linear in the slopes of h, which must not be
    negative, and in the offset: both follow from non-negative least squares. The logarithms of the
    weights are searched by least squares. Thresholds are spread over the longest way out, and nine
    knots over the range of P there. Numbers that the curves leave open become even: the logarithms
    of the weights, and neighboring slopes, are drawn together in proportion to the noise of the
    torque. All stops are at zero at the beginning of the curves, as before any motion.

    Args:
        curves: Curves that all begin at one angle and with one torque, zero or not.
        thresholds: Number of stops.
    """
    at_least("thresholds", thresholds, 1)
    problem = _Hinges(usable(curves), thresholds)
    search = least_squares(
        problem.residual,
        np.zeros(thresholds + 1),
        problem.jacobian,  # type: ignore[arg-type]
        bounds=(SMALLEST, LARGEST),
        ftol=STALLED,
        xtol=STALLED,
        max_nfev=MOST_STEPS,
    )
    return problem.model(search.x)


class _Hinges:
    """The errors of weights, with the best hinge function.

    Torques count over the span of the measured ones, and P over its largest size.
    """

    def __init__(self, curves: Sequence[Curve], thresholds: int) -> None:
        self.start = common_start(curves)
        self.reach = max(float(np.abs(curve.angle - curve.angle[0]).max()) for curve in curves)
        self.thresholds = self.reach * np.linspace(*THRESHOLDS, thresholds)
        sliders = [
            PrandtlIshlinskii(stiffness=0, thresholds=[r], weights=[1])
            for r in self.thresholds.tolist()
        ]
        spring = np.concatenate([curve.angle - curve.angle[0] for curve in curves])
        self.strains = np.column_stack([spring, responses(curves, sliders)]) / self.reach
        torque = np.concatenate([curve.torque for curve in curves])
        self.size, self.mean = float(np.ptp(torque)), float(np.mean(torque))
        self.torque = (torque - self.mean) / self.size
        noise = max(noise_floor(curves) / self.size, LEAST_NOISE)
        self.evenness = noise / WEIGHT_SPREAD
        self.smoothness = noise / SLOPE_STEP * np.diff(np.eye(KNOTS + 1), axis=0)

    def residual(self, logs: Array) -> Array:
        """Returns the relative errors, and how uneven slopes and weights are."""
        rows, slopes, _ = self.hinge(self.strains @ self.weights(logs))
        errors = rows @ slopes
        errors[: self.torque.size] -= self.torque
        return np.concatenate([errors, self.evenness * logs])

    def jacobian(self, logs: Array) -> Array:
        """Returns the derivatives of `residual`, where the slopes of h follow the weights.

        The part that other slopes can undo is taken off (Kaufman, BIT 15, 1975, 49).
        """
        moved = self.strains * self.weights(logs)
        P = moved.sum(axis=1)
        farthest = np.argmax(np.abs(P))
        moved -= np.outer(P, moved[farthest] / P[farthest])
        rows, slopes, _ = self.hinge(P)
        change = np.zeros((len(rows), logs.size))
        change[: P.size] = slopes[np.searchsorted(_knots(P), P), None] * moved
        change[: P.size] -= change[: P.size].mean(axis=0)
        basis, _ = np.linalg.qr(rows[:, slopes > LEAST_SLOPE])
        change = beside(basis, change)
        return np.vstack([change, self.evenness * np.eye(logs.size)])

    def weights(self, logs: Array) -> Array:
        """Returns the weights of spring and stops with which the largest |P| is 1."""
        weights = np.exp(logs)
        return weights / np.abs(self.strains @ weights).max()

    def hinge(self, P: Array) -> tuple[Array, Array, Array]:
        """Solves the problem that is linear in the slopes of h.

        Returns its rows (the share of P on each piece of h less its mean, and the rows that draw
        neighboring slopes together), the best slopes, and the means of the shares.
        """
        ends = np.array([-np.inf, *_knots(P), np.inf])
        parts = np.clip(P[:, None], ends[:-1], ends[1:]) - np.clip(0.0, ends[:-1], ends[1:])
        middle = parts.mean(axis=0)
        rows = np.vstack([parts - middle, self.smoothness])
        target = np.append(self.torque, np.zeros(len(self.smoothness)))
        target -= LEAST_SLOPE * rows.sum(axis=1)
        triangle = np.asarray(np.linalg.qr(np.column_stack([rows, target]), mode="r"))
        slopes, _ = nnls(triangle[:, :-1], triangle[:, -1], maxiter=MOST_PIVOTS * (KNOTS + 1))
        return rows, LEAST_SLOPE + slopes, middle

    def model(self, logs: Array) -> HingedStops:
        """Returns the model of these weights, whose P is as large as the torque."""
        weights = self.weights(logs)
        P = self.strains @ weights
        _, slopes, middle = self.hinge(P)
        offset = self.mean - self.size * float(middle @ slopes)
        stiffness, *stops = (self.size / self.reach * weights).tolist()
        return HingedStops(
            stiffness=stiffness,
            thresholds=self.thresholds.tolist(),
            weights=stops,
            knots=(self.size * _knots(P)).tolist(),
            slopes=slopes.tolist(),
            offset=offset,
            rest_angle=self.start,
        )


def _knots(P: Array) -> Array:
    """Returns the knots of h, evenly from P = 0 to the farthest, in increasing order."""
    farthest = P[np.argmax(np.abs(P))]
    return np.sort(farthest * np.arange(1, KNOTS + 1) / (KNOTS + 1))
