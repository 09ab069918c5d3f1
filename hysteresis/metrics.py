"""Measures the size and the shape of one hysteresis loop."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import isotonic_regression

from ..arrays import Array
from ..errors import InputError
from .loops import LARGEST, finite_record

OPEN_AT_MOST = 0.25  # share of the angle's range; a wider gap, or a longer way back, is no loop
TANGENT_SPAN = 0.05  # share of the angle's range
LARGEST_TANGENT_SPAN = 0.25  # share of the angle's range
SMALLEST_SPAN = 1 / LARGEST  # rad


@dataclass(frozen=True, kw_only=True)
class LoopMetrics:
    """Size and shape of a loop whose two branches run between its lowest and highest angle.

    Attributes:
        area: Work that the cycle takes, the closed integral of torque over angle [J]; positive if
            the loop dissipates, negative if it drives (magnetization over field is negative).
        center: Angle to which remanence and asymmetry refer [rad].
        mid_torque: Mean torque of the two branches at the center [N·m]; 0 for a loop that is
            symmetric about the center and zero torque.
        remanence: Half the difference in torque of the two branches at the center [N·m]. Where
            their torques have opposite signs it is the mean of |torque|; with center 0 that is Mr
            of magnetics.
        coercive_angle: Half the angle between the points where the two branches pass the mid torque
            [rad]; for a symmetric loop and center 0 it is Hc of magnetics. NaN if a branch never
            passes the mid torque.
        peak_torque: Largest |torque| [N·m].
        closure_error: Torque at the end of the cycle minus torque at its start [N·m].
        secant_stiffness: Slope between the torques with which the branches arrive at the lowest and
            at the highest angle [N·m/rad].
        stiffness_into_low: Slope with which the falling branch arrives at the low turn [N·m/rad].
        stiffness_out_of_low: Slope with which the rising branch leaves the low turn [N·m/rad].
        stiffness_into_high: Slope with which the rising branch arrives at the high turn [N·m/rad].
        stiffness_out_of_high: Slope with which the falling branch leaves the high turn [N·m/rad].
        asymmetry: Root mean square difference between the rising branch and the falling branch
            mirrored at the point (center, mid_torque), over the angles that both have, divided by
            the range of the torque; 0 for a point-symmetric loop.
    """

    area: float
    center: float
    mid_torque: float
    remanence: float
    coercive_angle: float
    peak_torque: float
    closure_error: float
    secant_stiffness: float
    stiffness_into_low: float
    stiffness_out_of_low: float
    stiffness_into_high: float
    stiffness_out_of_high: float
    asymmetry: float


@dataclass(frozen=True, eq=False)
class _Path:
    """A way from one turn of the closed cycle to the other.

    Between the samples `seam` and `seam + 1` it follows the closing line, if `seam` is not -1.
    """

    angle: Array
    torque: Array
    seam: int

    def mirrored(self, center: float, mid_torque: float) -> "_Path":
        """Returns the path turned by 180 degrees about a point: a falling branch becomes rising."""
        return _Path(2 * center - self.angle, 2 * mid_torque - self.torque, self.seam)

    def backwards(self) -> "_Path":
        seam = self.angle.size - 2 - self.seam if self.seam >= 0 else -1
        return _Path(self.angle[::-1], self.torque[::-1], seam)

    def measured(self, near: float) -> "_Path":
        """Returns the path without a closing line at its beginning, where the cycle is open."""
        if self.seam < 0:
            return self
        first, last = self.seam, self.seam + 1
        far = np.abs(self.angle[: last + 1] - self.angle[0]).max() > near
        closed = self.angle[first] == self.angle[last] and self.torque[first] == self.torque[last]
        if far or closed:
            return self
        return _Path(self.angle[last:], self.torque[last:], -1)


def loop_metrics(
    angle: ArrayLike,
    torque: ArrayLike,
    *,
    center: float | None = None,
    tangent_span: float | None = None,
) -> LoopMetrics:
    """Measures one loop.

    The cycle may begin anywhere, at a turn or not; a straight line from its last sample to its
    first closes it. Slopes and tips come from samples alone: a closing line within `tangent_span`
    of a turn, where a first-order transition curve is open, is left out of them. Between samples
    the torque is linear, so the numbers are exact for piecewise linear loops. Where jitter makes a
    noisy branch pass a level several times, the median of the passages counts; a record with more
    noise than that needs `smooth` first.

    Args:
        angle: Joint angles of one cycle [rad], shape (n,), n >= 3, in the order of motion.
        torque: Torques [N·m], shape (n,).
        center: Angle at which to measure the remanence [rad]; None takes the middle of the range.
        tangent_span: Distance from a turn up to which samples give the slope there [rad], that of
            a least-squares line through at least two; None takes 5 % of the range, and 25 % is the
            most. A dwell at the turn does not count.

    Returns:
        The metrics.

    Raises:
        InputError: The series are not a record of one closed cycle, the center is outside the
            loop, or the tangent span is out of its range.
    """
    angle, torque = finite_record(angle, torque)
    up, down = _rising_and_falling(angle, torque)
    center, tangent_span = _chosen(angle, center, tangent_span)
    upper = _passage(up.angle, up.torque, center)
    lower = _passage(-down.angle, down.torque, -center)
    mid_torque = (upper + lower) / 2
    widest = _passage(-down.torque, down.angle, -mid_torque) - _passage(
        up.torque, up.angle, mid_torque
    )
    into_low = down.backwards().measured(tangent_span)
    into_high = up.backwards().measured(tangent_span)
    return LoopMetrics(
        area=float(np.trapezoid(_closed(torque), _closed(angle))),
        center=center,
        mid_torque=mid_torque,
        remanence=abs(upper - lower) / 2,
        coercive_angle=abs(widest) / 2,
        peak_torque=float(np.abs(torque).max()),
        closure_error=float(torque[-1] - torque[0]),
        secant_stiffness=_secant(into_low, into_high),
        stiffness_into_low=_slope(into_low, tangent_span),
        stiffness_out_of_low=_slope(up.measured(tangent_span), tangent_span),
        stiffness_into_high=_slope(into_high, tangent_span),
        stiffness_out_of_high=_slope(down.measured(tangent_span), tangent_span),
        asymmetry=_asymmetry(up, down.mirrored(center, mid_torque), float(np.ptp(torque))),
    )


def _chosen(angle: Array, center: float | None, tangent_span: float | None) -> tuple[float, float]:
    low, high = float(angle.min()), float(angle.max())
    center = (low + high) / 2 if center is None else float(center)
    if not low < center < high:
        raise InputError(
            f"center is {center:.6g} rad: choose it inside the loop, between {low:.6g} and "
            f"{high:.6g} rad"
        )
    tangent_span = TANGENT_SPAN * (high - low) if tangent_span is None else float(tangent_span)
    largest = LARGEST_TANGENT_SPAN * (high - low)
    if not 0 < tangent_span <= largest:
        raise InputError(
            f"tangent_span is {tangent_span:.6g} rad: use more than 0, and at most {largest:.6g} "
            "rad in this loop"
        )
    return center, tangent_span


def _closed(values: Array) -> Array:
    return np.append(values, values[0])


def _rising_and_falling(angle: Array, torque: Array) -> tuple[_Path, _Path]:
    span = float(np.ptp(angle))
    gap = abs(float(angle[-1] - angle[0]))
    if span < SMALLEST_SPAN or gap > OPEN_AT_MOST * span:
        raise InputError(
            f"the angle covers {span:.3g} rad and ends {gap:.3g} rad from its start, which is no "
            "closed loop: give one cycle that turns and comes back (`loops` finds them in a record)"
        )
    at_low, at_high = _arrival(angle, angle.min()), _arrival(angle, angle.max())
    paths: list[_Path] = []
    for start, stop, sign in ((at_low, at_high, 1), (at_high, at_low, -1)):
        along = (start + np.arange((stop - start) % angle.size + 1)) % angle.size
        wraps = np.flatnonzero(along[:-1] == angle.size - 1)
        path = _Path(angle[along], torque[along], int(wraps[0]) if wraps.size else -1)
        way_back = float(np.max(np.maximum.accumulate(sign * path.angle) - sign * path.angle))
        if way_back > OPEN_AT_MOST * span:
            raise InputError(
                f"the angle turns back by {way_back:.3g} rad on its way through the loop's "
                f"{span:.3g} rad: give a single cycle (`loops` splits a record)"
            )
        paths.append(path)
    return paths[0], paths[1]


def _arrival(angle: Array, extreme: float) -> int:
    """Returns the index of the first sample of the cycle's dwell at an extreme angle."""
    there = angle == extreme
    return int(np.flatnonzero(there & ~np.roll(there, 1))[0])


def _passage(x: Array, y: Array, level: float) -> float:
    """Returns y where x passes a level in the sense of its first passage; NaN if it never does."""
    above = x > level
    changes = np.flatnonzero(above[1:] != above[:-1])
    if changes.size == 0:
        return math.nan
    before = changes[above[changes + 1] == above[changes[0] + 1]]
    after = before + 1
    part = (level - x[before]) / (x[after] - x[before])
    return float(np.median(y[before] + part * (y[after] - y[before])))


def _secant(one: _Path, other: _Path) -> float:
    return float((other.torque[0] - one.torque[0]) / (other.angle[0] - one.angle[0]))


def _slope(path: _Path, span: float) -> float:
    """Returns the stiffness with which a path leaves its first angle."""
    distance = np.abs(path.angle - path.angle[0])
    start = int(np.argmax(distance > 0)) - 1
    beyond = np.flatnonzero(distance > span * (1 + 1e-9))
    stop = max(int(beyond[0]), start + 2)
    x, y = path.angle[start:stop], path.torque[start:stop]
    x = x - x.mean()
    return float(x @ y / (x @ x))


def _asymmetry(one: _Path, other: _Path, scale: float) -> float:
    """Returns the RMS difference of two rising paths over the angles they share."""
    first, second = (isotonic_regression(path.angle).x for path in (one, other))
    low, high = max(first[0], second[0]), min(first[-1], second[-1])
    grid = np.unique(np.clip(np.concatenate([first, second]), low, high))
    if scale == 0:
        return 0.0
    # The difference is linear between grid points, so its square integrates exactly.
    gap = np.interp(grid, first, one.torque) - np.interp(grid, second, other.torque)
    squares = (gap[1:] ** 2 + gap[1:] * gap[:-1] + gap[:-1] ** 2) / 3
    return math.sqrt(float(squares @ np.diff(grid)) / (high - low)) / scale
