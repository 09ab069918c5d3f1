"""The verdict on a believed suit, valid, usable or not valid, by its torque along real motions.

The verdict is by torque and not by relief, since relief depends little on the torque: a torque that
is 20 % too large everywhere still has 93 % of the relief of the true model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS, SuitJoint
from ...errors import InputError
from ...tables import Rows
from .rollout import Trace
from .statistics import Interval, interval_of, mean_interval

LIMITS = {"valid": 0.05, "usable": 0.15}
"""Largest NRMSE of the torque for each verdict.

A torque that is 20 % wrong everywhere has an NRMSE of 0.10, since the torque is mostly below its
peak. So the limit of a valid model is an error of about 10 % everywhere, the limit of a usable
model about 30 %. The straight spring through the middle of a loop has an NRMSE of 0.22 to 0.28: a
model without hysteresis is not valid.
"""
NOT_VALID = "not valid"
RULE = (
    "The verdict is by the root mean square of the torque error over the largest true torque, of "
    "the joint where the upper end of the 95 % interval is highest: "
    + ", ".join(f"{name} up to {limit:.0%}" for name, limit in LIMITS.items())
    + f", {NOT_VALID} beyond; and it holds for these angles only."
)
LEAST_TORQUE = 0.01  # [N·m], least resistance of a joint that is judged
FARTHEST = 0.2  # [s], greatest lag that can be found
FINEST = 0.001  # [s], resolution of the lag


def verdict(nrmse: float) -> str:
    """Returns "valid", "usable" or "not valid" for a torque error, as `LIMITS` says."""
    return next((name for name, limit in LIMITS.items() if nrmse <= limit), NOT_VALID)


@dataclass(frozen=True, kw_only=True)
class TorqueError:
    """Believed less true resistance along motions, with intervals over the motions.

    Root mean square and mean are over all joints, and the peak is the largest of all joints.

    Attributes:
        rms: Root mean square [N·m].
        peak: Largest absolute error in a motion, mean over motions [N·m].
        bias: Mean [N·m].
        lag: Time by which the believed torque comes later than the true torque [ms]; see `lag_of`.
        nrmse: Root mean square of each joint's error over its largest true torque in all motions;
            the interval treats the largest torque as exact.
    """

    rms: Interval
    peak: Interval
    bias: Interval
    lag: Interval
    nrmse: Interval


@dataclass(frozen=True, kw_only=True)
class TorqueErrors:
    """Torque errors of a believed suit along motions, and the verdict.

    Attributes:
        joints: Torque error of each assisted joint that both suits have.
        together: Torque error of these joints together; None without such joints.
        covered: Lowest and highest angle of the motions [rad], by joint.
        noise: Root mean square residual of the fit of the believed joint [N·m], by joint; None
            where the suit file has no residual.
    """

    joints: dict[str, TorqueError]
    together: TorqueError | None
    covered: dict[str, tuple[float, float]]
    noise: dict[str, float | None]

    @property
    def nrmse(self) -> Interval | None:
        """NRMSE of the joint with the highest upper end, which sets the verdict; None if none."""
        found = [error.nrmse for error in self.joints.values()]
        return max(found, key=lambda one: one.high, default=None)

    @property
    def verdict(self) -> str | None:
        """The verdict by the upper end of `nrmse`; None without joints."""
        return None if self.nrmse is None else verdict(self.nrmse.high)


def torque_errors(believed: Mapping[str, SuitJoint], traces: Sequence[Trace]) -> TorqueErrors:
    """Compares believed joints, by name, with the true torque along at least 8 motions.

    The models follow the true angles of each control period, from the initial state of their
    memory. A motion through the pole of an uncertified model raises `PoleError`.
    """
    expected: dict[str, list[Array]] = {}
    true: dict[str, list[Array]] = {}
    covered = {}
    for name, joint in believed.items():
        at = JOINTS.index(name)
        worn = [-one.suit_torque[:, at] for one in traces]
        if max(float(np.abs(one).max()) for one in worn) < LEAST_TORQUE:
            continue
        angles, true[name] = [one.angle[:, at] for one in traces], worn
        pairs = zip(angles, traces, strict=True)
        expected[name] = [joint.response(angle, time=one.time) for angle, one in pairs]
        whole = np.concatenate(angles)
        covered[name] = float(whole.min()), float(whole.max())

    def error(*names: str) -> TorqueError:
        motions = (zip(*(of[name] for name in names), strict=True) for of in (expected, true))
        one, other = ([np.stack(motion, axis=1) for motion in some] for some in motions)
        return torque_error(one, other, float(traces[0].time[0]))

    return TorqueErrors(
        joints={name: error(name) for name in true},
        together=error(*true) if true else None,
        covered=covered,
        noise={name: noise_of(believed[name]) for name in true},
    )


def torque_error(believed: Sequence[Array], true: Sequence[Array], dt: float) -> TorqueError:
    """Compares believed with true resistance [N·m], shape (n, joints), in at least 8 motions."""
    largest = np.max([np.abs(one).max(axis=0) for one in true], axis=0)
    pairs = list(zip(believed, true, strict=True))
    apart = [one - other for one, other in pairs]
    return TorqueError(
        rms=_root_interval([float(np.mean(error**2)) for error in apart]),
        peak=mean_interval([np.abs(error).max() for error in apart]),
        bias=mean_interval([error.mean() for error in apart]),
        lag=mean_interval([1e3 * lag_of(*pair, dt) for pair in pairs]),
        nrmse=_root_interval([float(np.mean((error / largest) ** 2)) for error in apart]),
    )


def _root_interval(squares: Sequence[float]) -> Interval:
    """Returns the interval of a root mean square from mean squares of motions."""
    found = interval_of(lambda mean: np.sqrt(np.maximum(mean, 0)), squares)
    return Interval(found.value, max(0.0, found.low), found.high)


def lag_of(late: Array, early: Array, dt: float) -> float:
    """Returns the time by which the record `late` comes later than `early` [s], (n, columns) each.

    The time is the shift, in steps of 1 ms up to 0.2 s, with the greatest sum of correlations of
    the columns over the middle of the records; 0 where a record is constant there.
    """
    time = dt * np.arange(len(late))
    farthest = min(FARTHEST, time[-1] / 4)
    middle = (time >= farthest) & (time <= time[-1] - farthest)
    shifts = FINEST * np.arange(-round(farthest / FINEST), round(farthest / FINEST) + 1)
    alike = np.zeros_like(shifts)
    for one, other in zip(late.T, early.T, strict=True):
        rows, same = np.interp(time[middle] + shifts[:, None], time, one), other[middle]
        rows, same = rows - rows.mean(axis=1, keepdims=True), same - same.mean()
        size = np.linalg.norm(rows, axis=1) * np.linalg.norm(same)
        alike += np.divide(rows @ same, size, out=np.zeros_like(size), where=size > 0)
    best = np.flatnonzero(alike >= alike.max() - 1e-12)
    return float(shifts[best[np.abs(shifts[best]).argmin()]])


def noise_of(joint: SuitJoint) -> float | None:
    """Returns the root mean square residual of a joint's fit [N·m]; None if it is not known.

    The suit file has the residual over the largest torque of the curves, for which the largest
    torque of the model along one loading and unloading over its range is taken.
    """
    if joint.fit_nrmse is None:
        return None
    low, high = joint.range
    loop = np.concatenate([np.linspace(low, high, 100), np.linspace(high, low, 100)])
    return joint.fit_nrmse * float(np.abs(joint.response(loop)).max())


@dataclass(frozen=True, kw_only=True)
class CurveError:
    """Predicted less measured torque of one curve."""

    curve: str
    rms: float  # root mean square [N·m]
    peak: float  # largest absolute error [N·m]
    bias: float  # mean [N·m]
    nrmse: float  # root mean square over the largest measured torque of the curve


def curve_errors(joint: SuitJoint, curves: Mapping[str, tuple[Array, Array]]) -> list[CurveError]:
    """Compares a joint with measured curves, each from the initial state of the joint's memory.

    Curves are angles [rad] and measured torques [N·m], by name.
    """
    found = []
    for name, (angle, torque) in curves.items():
        error, largest = joint.response(angle) - torque, np.abs(torque).max()
        if largest == 0:
            raise InputError(f"curve {name!r} has no torque: leave it out")
        rms, peak = float(np.sqrt(np.mean(error**2))), float(np.abs(error).max())
        sizes = {"rms": rms, "peak": peak, "bias": float(error.mean())}
        found.append(CurveError(curve=name, **sizes, nrmse=rms / float(largest)))
    return found


@dataclass(frozen=True, kw_only=True)
class CurvePrediction:
    """Errors of suits on each measured curve, by suit and joint; `notes` name unused curves."""

    errors: Mapping[str, Mapping[str, list[CurveError]]]
    notes: Sequence[str] = ()

    @property
    def _verdicts(self) -> dict[tuple[str, str], str]:
        """Verdicts by suit and joint."""
        return {
            (suit, joint): verdict(max(error.nrmse for error in errors))
            for suit, joints in self.errors.items()
            for joint, errors in joints.items()
        }

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        found: dict[str, dict[str, Any]] = {suit: {} for suit in self.errors}
        for (suit, joint), said in self._verdicts.items():
            curves = [asdict(one) for one in self.errors[suit][joint]]
            found[suit][joint] = {"verdict": said, "curves": curves}
        return {"limits": LIMITS, "suits": found}

    def tables(self) -> dict[str, Rows]:
        """Returns the errors of all curves, by title."""
        header = ["suit", "joint", "curve", "RMS\n[N·m]", "largest\n[N·m]", "bias\n[N·m]"]
        rows = []
        for suit, joint in self._verdicts:
            for one in self.errors[suit][joint]:
                sizes = (f"{value:z.2f}" for value in (one.rms, one.peak, one.bias))
                rows.append([suit, joint, one.curve, *sizes, f"{100 * one.nrmse:.1f}"])
        return {"Torque, predicted less measured": ([*header, "RMS of the\npeak [%]"], rows)}

    def sentences(self) -> list[str]:
        """Returns the verdict on each joint of each suit."""
        verdicts = [f"{suit}, {joint}: {said}" for (suit, joint), said in self._verdicts.items()]
        return [*self.notes, *verdicts, f"{RULE} Of curves, the worst one decides."]
