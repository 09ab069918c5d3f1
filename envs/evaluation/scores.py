"""The score of a policy: values of each motion, and values of all motions together."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ..interface.reward import COSTS
from ..model import ASSISTED
from ..model.cuffs import CUFFS
from ..person import EffortMetrics, effort_metrics, endurance_time, spectral_arc_length
from ..tasks.task import SUSTAINED, Limit
from .reasons import Reason
from .rollout import Trace

Values = tuple[float, ...]
REFERENCES = ("unsuited", "suited")
UNADAPTED = ("unadapted_effort", "unadapted_tracking")  # of wearers who have learned nothing
BEGINNING = 0.5  # s
SAME_ANGLE = 1e-6  # rad
TINY = 1e-9  # a sum of rewards that counts as none
_ASSISTED = [JOINTS.index(joint) for joint in ASSISTED]


@dataclass(frozen=True, kw_only=True)
class Score:
    """Score of a policy over some motions; a tuple has one value per motion, in their order.

    Attributes:
        policy: Name of the policy.
        motion: Number of the first motion with the same intention: motions of different seeds may
            be the same.
        effort: Root mean square, over time and four joints, of the wearer's torque over strength,
            with co-contraction.
        net_effort: The same of the net torque alone, without co-contraction.
        assisted_effort: Effort over the two joints that can have a motor.
        torque: Root mean square of the wearer's torque [N·m], by joint.
        peak: Largest |torque| of the wearer over all motions [N·m], by joint.
        tracking: Root mean square, over time and four joints, of the tracking error [rad].
        tracking_rmse: Root mean square of the tracking error over all motions [rad], by joint.
        reward: Mean reward of a control period of the whole motion, in [0, 1]; 0 counts after the
            end of an episode that ended early.
        beginning: Share of the first half second in the sum of the rewards.
        above_limit: Share of time in which the effort of a joint is above the usual limit of
            tasks, `SUSTAINED`.
        endurance: Time for which the joint that tires first could bear the mean effort [s], by
            `envs.person.endurance_time`; infinite where no joint tires.
        smoothness: SPARC of the hand's speed, negative, nearer zero if smoother.
        completion: Time of a successful motion [s]; NaN for a failed motion.
        success: Whether the motion exceeded no limit of success.
        why: Limits of success that the motion exceeded, each with value, limit, unit and time.
        limits: Limits of success of the task.
        hot_from: First time at which the motor of a joint was hot, and limited to its continuous
            torque [s], by joint; infinite for a motor that never was.
        saturated: Share of time in which the motor gave its peak torque, by joint.
        fatigued: Fatigued part at the end of the motion, of the more fatigued of a joint's
            extensors and flexors, by joint; empty where muscles do not tire.
        strength_left: Least strength in the motion of the weaker of a joint's muscles [N·m], at
            rest in the postures of the motion and with fatigue, by joint.
        costs: Cost terms of the motion, by name.
        load: Mean over motions of the wearer's `EffortMetrics`, by joint.
        cuff_peak: Greatest force over all motions [N] by limb segment; None without cuffs.
        assist_energy: Energy of the motors [J].
        failures: Number of episodes that ended early.
        guarded: Share of time in which a passivity guard reduced the motors' torque; empty without
            a guard.
        unadapted_effort: Effort of a wearer who has not learned the motion; empty if not run.
        unadapted_tracking: Tracking error of that wearer [rad]; empty if not run.
    """

    policy: str
    motion: tuple[int, ...]
    effort: Values
    net_effort: Values
    assisted_effort: Values
    torque: dict[str, Values]
    peak: dict[str, float]
    tracking: Values
    tracking_rmse: dict[str, float]
    reward: Values
    beginning: Values
    above_limit: Values
    endurance: Values
    smoothness: Values
    completion: Values
    success: tuple[bool, ...]
    why: tuple[tuple[Reason, ...], ...]
    limits: tuple[Limit, ...]
    hot_from: dict[str, Values]
    saturated: dict[str, Values]
    fatigued: dict[str, Values]
    strength_left: dict[str, Values]
    costs: dict[str, Values]
    load: dict[str, dict[str, float]]
    cuff_peak: dict[str, float] | None
    assist_energy: Values
    failures: int
    guarded: Values = ()
    unadapted_effort: Values = ()
    unadapted_tracking: Values = ()

    @property
    def distinct(self) -> int:
        """Number of different motions."""
        return len({*self.motion})

    @property
    def human_rms(self) -> dict[str, float]:
        """Root mean square of the wearer's torque over all motions [N·m], by joint."""
        return {joint: root_mean_square(values) for joint, values in self.torque.items()}

    def to_dict(self) -> dict[str, Any]:
        """Returns the score as plain values, with the units of its numbers under "units"."""
        return {**asdict(self), "distinct": self.distinct, "units": UNITS}


UNITS: dict[str, Any] = {
    **dict.fromkeys(("motion", "effort", "net_effort", "assisted_effort"), "1"),
    **dict.fromkeys(("unadapted_effort", "above_limit"), "1"),
    **dict.fromkeys(("reward", "beginning", "smoothness", "guarded", "saturated", "fatigued"), "1"),
    **dict.fromkeys(("torque", "peak", "strength_left"), "N·m"),
    **dict.fromkeys(("tracking", "tracking_rmse", "unadapted_tracking"), "rad"),
    **dict.fromkeys(("endurance", "completion", "hot_from"), "s"),
    **{"cuff_peak": "N", "assist_energy": "J"},
    "costs": {
        **dict.fromkeys(("cuff_force", "heat", "chatter", "effort", "slowness"), "1"),
        **{"wrong_way_work": "J", "range_stops": "s", "hand_error": "m"},
        **dict.fromkeys(("tilt", "tracking", "worst_joint"), "rad"),
    },
    "load": {
        **{"impulse": "N·m·s", "positive_work": "J", "negative_work": "J", "work_cost": "J"},
        **{"torque_cost": "(N·m)^1.36·s", "spectral_arc_length": "1"},
        "log_dimensionless_jerk": "1",
    },
}
"""Units of the numbers of a score, "1" for a ratio; limits and reasons contain their units."""


def score(policy: str, traces: Sequence[Trace], unadapted: Sequence[Trace] = ()) -> Score:
    """Summarizes motions of a policy, and motions of wearers who have not learned the motions."""
    human = np.concatenate([trace.human_torque for trace in traces])
    error = np.concatenate([trace.angle - trace.target_angle for trace in traces])

    def each(of: Callable[[Trace], Any], motions: Sequence[Trace] = traces) -> Values:
        return tuple(float(of(trace)) for trace in motions)

    def each_of(joints: Sequence[str], of: Callable[[Trace], Any]) -> dict[str, Values]:
        """Returns the values of all motions by joint; empty if a motion has no values."""
        columns = zip(*map(of, traces), strict=True)
        return {joint: tuple(map(float, one)) for joint, one in zip(joints, columns, strict=False)}

    def effort(trace: Trace) -> float:
        return root_mean_square(trace.effort)

    def tracking(trace: Trace) -> float:
        return root_mean_square(trace.angle - trace.target_angle)

    return Score(
        policy=policy,
        motion=same_motions(traces),
        effort=each(effort),
        net_effort=each(_net_effort),
        assisted_effort=each(lambda one: root_mean_square(one.effort[:, _ASSISTED])),
        torque=each_of(JOINTS, lambda one: map(root_mean_square, one.human_torque.T)),
        peak=_by_joint(np.abs(human).max(axis=0)),
        tracking=each(tracking),
        tracking_rmse=_by_joint(np.sqrt(np.mean(error**2, axis=0))),
        reward=each(lambda one: one.rewards.sum() / one.periods),
        beginning=each(
            lambda one: one.rewards[one.time <= BEGINNING].sum() / max(one.rewards.sum(), TINY)
        ),
        above_limit=each(lambda one: np.mean(one.effort.max(axis=1) > SUSTAINED)),
        endurance=each(_endurance),
        smoothness=each(_smoothness),
        completion=each(lambda one: one.time[-1] if one.success else np.nan),
        success=tuple(trace.success for trace in traces),
        why=tuple(trace.why for trace in traces),
        limits=traces[0].limits,
        hot_from=each_of(ASSISTED, lambda one: one.hot_from),
        saturated=each_of(ASSISTED, lambda one: one.saturated),
        fatigued=each_of(
            JOINTS, lambda one: () if one.fatigue is None else one.fatigue[-1].max(axis=0)
        ),
        strength_left=each_of(JOINTS, lambda one: one.strength.min(axis=(0, 1))),
        costs={name: tuple(trace.costs[name] for trace in traces) for name in COSTS},
        load=_load(traces),
        cuff_peak=_cuff_peak(traces),
        assist_energy=each(lambda one: one.assist_energy),
        failures=sum(trace.terminated for trace in traces),
        guarded=tuple(one.guarded / len(one.time) for one in traces if one.guarded is not None),
        unadapted_effort=each(effort, unadapted),
        unadapted_tracking=each(tracking, unadapted),
    )


def _net_effort(trace: Trace) -> float:
    torque, (extensors, flexors) = trace.human_torque, np.moveaxis(trace.strength, 1, 0)
    return root_mean_square(torque / np.where(torque > 0, flexors, extensors))


def same_motions(traces: Sequence[Trace]) -> tuple[int, ...]:
    """Returns for each motion the number of the first motion with the same intention.

    Intended angles that differ by at most 1e-6 rad are the same, in a motion that ended early as
    far as it went.
    """
    found: list[int] = []
    for i, one in enumerate(traces):
        angle = one.target_angle
        alike = (
            j
            for j, other in enumerate(traces[:i])
            if found[j] == j
            and np.allclose(*_cut(angle, other.target_angle), rtol=0, atol=SAME_ANGLE)
        )
        found.append(next(alike, i))
    return tuple(found)


def _cut(one: Array, other: Array) -> tuple[Array, Array]:
    """Returns two series, both as long as the shorter one."""
    samples = min(len(one), len(other))
    return one[:samples], other[:samples]


def _load(traces: Sequence[Trace]) -> dict[str, dict[str, float]]:
    """Returns mean effort metrics by joint; NaN if no motion has three samples."""
    found = [
        effort_metrics(trace.human_torque, trace.rate, trace.time[1] - trace.time[0])
        for trace in traces
        if len(trace.time) > 2
    ]

    def mean(name: str, column: int) -> float:
        return float(np.mean([getattr(one, name)[column] for one in found])) if found else np.nan

    names = [field.name for field in fields(EffortMetrics) if field.name not in ("rms", "peak")]
    return {joint: {name: mean(name, i) for name in names} for i, joint in enumerate(JOINTS)}


def _endurance(trace: Trace) -> float:
    loads = np.minimum(trace.effort.mean(axis=0), 1.0)
    return min(map(float, map(endurance_time, loads, JOINTS)))


def _smoothness(trace: Trace) -> float:
    if len(trace.time) < 3:
        return float("nan")
    dt = trace.time[1] - trace.time[0]
    speed = np.linalg.norm(np.diff(trace.hand, axis=0), axis=1) / dt
    return float(spectral_arc_length(speed, dt))


def _cuff_peak(traces: Sequence[Trace]) -> dict[str, float] | None:
    forces = [trace.cuff_force for trace in traces if trace.cuff_force is not None]
    if not forces:
        return None
    peak = np.linalg.norm(np.concatenate(forces), axis=-1).max(axis=0)
    return dict(zip(CUFFS, peak.tolist(), strict=True))


def root_mean_square(values: Array | Values) -> float:
    """Returns the root mean square of some values."""
    return float(np.sqrt(np.mean(np.square(values))))


def _by_joint(values: Array) -> dict[str, float]:
    return dict(zip(JOINTS, map(float, values), strict=True))
