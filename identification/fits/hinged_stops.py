"""Hinged stops identified from first-order curves, by variable projection."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares, nnls

from ...arrays import Array
from ...checks import at_least
from ...hysteresis.stops import HingedStops, PrandtlIshlinskii
from ..curves import Curve, noise_floor
from .linear import LEAST_NOISE, MOST_PIVOTS, responses, usable
from .projection import common_start

THRESHOLDS = (0.03, 0.85)  # smallest and largest threshold over the longest way out
KNOTS = 9
WEIGHT_SPREAD = 1.0  # expected spread of the logarithms of the weights
SLOPE_STEP = 1.0  # expected difference of neighboring slopes of h, whose mean is about 1
LEAST_SLOPE = 0.02  # least slope of h, so that a torque determines where a motion begins
SMALLEST, LARGEST = -9.0, 4.0  # logarithm of a weight, relative to the others
STALLED = 1e-4  # relative change of cost or point that ends the search
MOST_STEPS = 40


def fit_hinged_stops(curves: Sequence[Curve], thresholds: int = 12) -> HingedStops:
    """Fits hinged stops, which are dissipative whatever their parameters, by variable projection.

    At fixed weights of spring and stops torque is linear in the slopes of h, which must not be
    negative, and in the offset: both follow from non-negative least squares. The logarithms of the
    weights are searched by least squares. Thresholds are spread over the longest way out, and nine
    knots over the P that belongs to it. What the curves leave open becomes even: the logarithms of
    the weights, and neighboring slopes, are drawn together in proportion to the noise of the
    torque. All stops are taken to be at zero where the curves begin, as before any motion.

    Args:
        curves: First-order curves, which all begin at one angle and with one torque, zero or not;
            those with role "fit" are used.
        thresholds: The number of stops.

    Returns:
        The model; `response(angle, initial_torque)` predicts a curve.
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
        """Returns the derivatives of `residual`, as the slopes of h follow the weights.

        What moving slopes can undo drops out (Kaufman, BIT 15, 1975, 49).
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
        change -= basis @ (basis.T @ change)
        return np.vstack([change, self.evenness * np.eye(logs.size)])

    def weights(self, logs: Array) -> Array:
        """Returns the weights of spring and stops with which the largest |P| is 1."""
        weights = np.exp(logs)
        return weights / np.abs(self.strains @ weights).max()

    def hinge(self, P: Array) -> tuple[Array, Array, Array]:
        """Returns the rows of the problem that is linear in the slopes of h, and its solution.

        Returns:
            The share of P on each piece of h less its mean, and the rows that draw neighboring
            slopes together; the best slopes; those means.
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
