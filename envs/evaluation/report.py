"""Simulated motions as tables, and as columns of CSV files."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...tables import Rows
from ..model import ASSISTED
from ..tasks.task import SUSTAINED
from .rollout import Trace
from .scores import REFERENCES, Score
from .statistics import interval_text

if TYPE_CHECKING:
    from .compare import Evaluation

Columns = tuple[list[str], Iterable[Sequence[str]]]  # the header of a CSV file, and its rows
REFERENCE = "compensation"  # policy that the others are compared with, motion by motion
UNITS = ("above_limit_share", "endurance_s", "hand_sparc", "completion_s", "wrong_way_work_j")
# Costs of a motion by the head of their column, with the format of their numbers.
EFFORT = {
    "impulse\n[N·m·s]": ("impulse", "z.1f"),
    "work on\nthe arm [J]": ("positive_work", "z.2f"),
    "taken\n[J]": ("negative_work", "z.2f"),
    "cost of\ntorque": ("torque_cost", "z.0f"),
    "cost of\nwork [J]": ("work_cost", "z.1f"),
    "smoothness\nSPARC": ("spectral_arc_length", "z.2f"),
}


def score_table(scores: Sequence[Score], evaluation: "Evaluation | None" = None) -> Rows:
    """Returns one row per policy: effort, torque by joint, tracking and success.

    With an evaluation of the scores that has references, rows have relief too.
    """
    header = ["policy", "effort\n[%]"]
    if evaluation is not None:
        header += ["relief,\n95 % interval", "of net\ntorque"]
        if REFERENCE in evaluation.scores:
            header += [f"relief less\n{REFERENCE}'s"]
        header += ["of the\nbound"]
    header += ["abduction/shoulder\n/elbow/wrist [N·m]", "error\n[mrad]", "went\nwell", "reward"]
    return header, [[score.policy, *_cells(score, evaluation)] for score in scores]


def _cells(score: Score, evaluation: "Evaluation | None") -> Iterator[str]:
    yield f"{100 * float(np.mean(score.effort)):.1f}"
    if evaluation is not None:
        yield interval_text(evaluation.relief(score.policy), lines=True)
        net = evaluation.net_relief(score.policy)
        yield "-" if net is None else f"{net.value:z.2f}"
        if REFERENCE in evaluation.scores:
            free = score.policy not in (*REFERENCES, REFERENCE)
            less = evaluation.relief_difference(score.policy, REFERENCE) if free else None
            yield interval_text(less, "+z.2f", lines=True)
        share = evaluation.share_of_bound(score.policy)
        yield "-" if share is None else f"{share.value:z.0%}"
    torques = (score.human_rms[joint] for joint in JOINTS)
    yield "/".join(f"{torque:.1f}" if torque >= 1 else f"{torque:.2f}" for torque in torques)
    yield f"{1e3 * float(np.mean(score.tracking)):.0f}"
    yield f"{np.mean(score.success):.0%}"
    yield f"{np.mean(score.reward):.3f}"


def effort_table(scores: Sequence[Score]) -> Rows:
    """Returns a row per policy and assisted joint: costs of a motion; first rows have the name."""
    rows = [
        [
            score.policy if joint == ASSISTED[0] else "",
            joint.removesuffix("_flexion"),
            *(f"{score.load[joint][cost]:{form}}" for cost, form in EFFORT.values()),
        ]
        for score in scores
        for joint in ASSISTED
    ]
    return ["policy", "joint", *EFFORT], rows


def units_table(scores: Sequence[Score]) -> Rows:
    """Returns one row per policy: medians over motions of usual measures of work."""
    header = ["policy", f"above {SUSTAINED:.0%}\n[% of time]", "endurance\n[s]", "hand\nSPARC"]
    header += ["completed\nin [s]", "wrong-way\nassist [J]"]
    rows = []
    for score in scores:
        known = [[value for value in one if not np.isnan(value)] for one in _units(score)]
        above, *rest = (float(np.median(one)) if one else np.nan for one in known)
        cells = ("-" if np.isnan(one) else f"{round(one, 6):.4g}" for one in rest)
        rows.append([score.policy, f"{100 * above:.0f}", *cells])
    return header, rows


def _units(score: Score) -> tuple[Sequence[float], ...]:
    return (
        *(score.above_limit, score.endurance, score.smoothness, score.completion),
        score.costs["wrong_way_work"],
    )


def score_columns(scores: Sequence[Score], first_seed: int) -> Columns:
    """Returns a row per policy and motion: effort, torque, tracking, reward, success, strength.

    Names of columns end with their units; a share has the unit 1. Where muscles tire, rows have the
    fatigued part of each joint's muscles at the end of the motion.
    """
    joints = [f"{joint}_torque_nm" for joint in JOINTS]
    header = ["policy", "seed", "effort_share", *joints, "tracking_rad", "reward", "success"]
    header += [*UNITS, *(f"{joint}_least_strength_nm" for joint in JOINTS)]
    tired = any(score.fatigued for score in scores)
    header += [f"{joint}_fatigued_share" for joint in JOINTS if tired]
    rows = []
    for score in scores:
        by_joint = (*score.strength_left.values(), *score.fatigued.values())
        before = (score.effort, *(score.torque[joint] for joint in JOINTS))
        columns = (*before, score.tracking, score.reward, score.success, *_units(score), *by_joint)
        for i, values in enumerate(zip(*columns, strict=True)):
            rows.append([score.policy, str(first_seed + i), *(f"{one:.6g}" for one in values)])
    return header, rows


def trace_columns(traces: Mapping[str, Trace]) -> Columns:
    """Returns motions as columns: policy, time [s], angles [rad], torques, strength [N·m], shares.

    Effort, fatigue and the load of a motor are shares of strength, of the muscles, and of the
    continuous torque. A cell is empty where muscles do not tire, or where there are no motors.
    """
    found = {policy: _series(trace) for policy, trace in traces.items()}
    header = list(dict.fromkeys(name for series in found.values() for name in series))
    rows = (
        [policy, *(f"{series[name][i]:.6g}" if name in series else "" for name in header)]
        for policy, series in found.items()
        for i in range(series["time_s"].size)
    )
    return ["policy", *header], rows


def _series(trace: Trace) -> dict[str, Array]:
    """Returns the time series of a trace, by the names of columns."""
    found = {"time_s": trace.time}
    extensor, flexor = (None, None) if trace.fatigue is None else np.moveaxis(trace.fatigue, 1, 0)
    for label, joints, values in (
        ("angle_rad", JOINTS, trace.angle),
        ("target_angle_rad", JOINTS, trace.target_angle),
        ("human_torque_nm", JOINTS, trace.human_torque),
        ("suit_torque_nm", JOINTS, trace.suit_torque),
        ("assist_torque_nm", ASSISTED, trace.assist_torque),
        ("effort", JOINTS, trace.effort),
        ("extensor_strength_nm", JOINTS, trace.strength[:, 0]),
        ("flexor_strength_nm", JOINTS, trace.strength[:, 1]),
        ("extensor_fatigue", JOINTS, extensor),
        ("flexor_fatigue", JOINTS, flexor),
        ("motor_load", ASSISTED, trace.motor_load),
    ):
        if values is not None:
            found |= {f"{joint}_{label}": values[:, i] for i, joint in enumerate(joints)}
    return found
