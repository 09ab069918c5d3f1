"""Why a motion did not go well: each limit of success that it exceeded, by how much and when."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ..model import ASSISTED
from ..model.cuffs import CUFFS
from ..reward import COSTS, JOINT, LIMITS, STRAIN, WIDTH, failed
from ..simulation.measurements import COLUMNS
from ..tasks import Task
from .oscillation import Oscillation, oscillation


@dataclass(frozen=True)
class Reason:
    """A limit of success that a motion exceeded.

    Attributes:
        name: Name of the cost, as in `Limit`.
        value: Cost of the motion.
        limit: Greatest cost with which it would have succeeded.
        unit: Unit of both, "1" for a ratio.
        time_s: Time at which it was first exceeded [s]. A root mean square is that of the whole
            motion: its time is that from which nothing could have kept it below the limit.
        part: Joint, motor or cuff that exceeded it; None where the whole hand did.
        oscillation: Oscillation that dominates the tracking error of the joint, with its amplitude
            in `unit`; None where there is none, and for other costs.
    """

    name: str
    value: float
    limit: float
    unit: str
    time_s: float
    part: str | None
    oscillation: Oscillation | None = None


def reasons(measured: Array, costs: Array, task: Task, *, lost: bool) -> tuple[Reason, ...]:
    """Returns why a motion failed; nothing if it succeeded.

    Args:
        measured: Measurements after each control period, shape (n, columns) as `COLUMNS`.
        costs: Costs of the episode after each control period, shape (n, 14).
        task: The task.
        lost: Whether the arm was lost at the end.
    """
    found = []
    for limit in failed(costs[-1], len(costs), task, ended=lost):
        course = _course(limit.name, costs)
        at = int(np.argmax(~(course <= limit.value)))
        part = _part(limit.name, measured, costs, at)
        time = float(measured[at, COLUMNS["time"].start])
        value = float(course[-1])
        swing = _oscillation(measured, part) if limit.name == "worst_joint" else None
        found.append(Reason(limit.name, value, limit.value, limit.unit, time, part, swing))
    return tuple(found)


def _course(cost: str, costs: Array) -> Array:
    """Returns a cost after each control period, shape (n,); means are over the whole motion."""
    if cost == "lost":
        return np.arange(len(costs)) == len(costs) - 1
    if cost in ("effort", "worst_joint"):
        columns = costs[:, [STRAIN]] if cost == "effort" else costs[:, JOINT:WIDTH]
        return np.sqrt(columns / len(costs)).max(axis=1)
    return costs[:, COSTS.index(cost)]


def _part(cost: str, measured: Array, costs: Array, at: int) -> str | None:
    """Returns the joint, motor or cuff that exceeds a limit at a control period."""

    def column(name: str) -> Array:
        return measured[:, COLUMNS[name]]

    if cost == "worst_joint":
        return JOINTS[int(np.argmax(costs[-1, JOINT:WIDTH]))]
    if cost == "effort":
        return JOINTS[int(np.argmax(np.square(column("effort")).mean(axis=0)))]
    if cost == "lost":
        return JOINTS[int(np.argmax(np.abs(column("angle") - column("target_angle"))[at]))]
    if cost == "heat":
        return ASSISTED[int(np.argmax(column("motor_load")[at]))]
    if cost == "cuff_force":
        force = np.linalg.norm(column("cuff_force")[at].reshape(3, 3), axis=1)
        return tuple(CUFFS)[int(np.argmax(force / LIMITS))]
    return None


def _oscillation(measured: Array, joint: str | None) -> Oscillation | None:
    """Returns the oscillation of a joint about its intended angle."""
    time, angle, intended = (
        measured[:, COLUMNS[name]] for name in ("time", "angle", "target_angle")
    )
    if joint is None or len(time) < 2:
        return None
    error = (angle - intended)[:, JOINTS.index(joint)]
    return oscillation(error, intended, float(time[1, 0] - time[0, 0]))


@dataclass(frozen=True)
class Frequent:
    """A limit that some motions exceeded.

    Attributes:
        name: Name of the cost.
        motions: Number of motions that exceeded it.
        value: Median cost of these.
        limit: Greatest cost with which they would have succeeded.
        unit: Unit of both, "1" for a ratio.
        time_s: Median of the times at which they exceeded it first [s].
        part: Joint, motor or cuff that did so most often; None where the whole hand did.
        oscillation: Medians of period and amplitude, where more than half of these oscillate.
    """

    name: str
    motions: int
    value: float
    limit: float
    unit: str
    time_s: float
    part: str | None
    oscillation: Oscillation | None = None


def most_frequent(why: Sequence[Sequence[Reason]]) -> tuple[Frequent, ...]:
    """Returns the limits that motions exceeded, the most frequent one first.

    Args:
        why: Reasons of each motion.
    """
    by_name: dict[str, list[Reason]] = {}
    for one in (reason for motion in why for reason in motion):
        by_name.setdefault(one.name, []).append(one)
    found = []
    for name, same in by_name.items():
        parts = [one.part for one in same]
        value, time = (
            float(np.median([getattr(r, of) for r in same])) for of in ("value", "time_s")
        )
        part = max(parts, key=parts.count)
        swing = _most(same)
        limit, unit = same[0].limit, same[0].unit
        found.append(Frequent(name, len(same), value, limit, unit, time, part, swing))
    return tuple(sorted(found, key=lambda one: -one.motions))


def _most(same: Sequence[Reason]) -> Oscillation | None:
    found = [one.oscillation for one in same if one.oscillation is not None]
    if 2 * len(found) <= len(same):
        return None
    periods, amplitudes = zip(*((one.period_s, one.amplitude) for one in found), strict=True)
    return Oscillation(float(np.median(periods)), float(np.median(amplitudes)))
