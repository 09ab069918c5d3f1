"""Simulated motions as tables, sentences, columns of CSV files and figures."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from statistics import fmean
from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...plots import PALETTE, Intervals, Panel, Plot
from ...tables import Rows
from ..model import ASSISTED
from ..model.cuffs import FORCE_LIMITS
from .core import REFERENCES
from .rollout import Trace
from .scores import Score
from .statistics import Interval

if TYPE_CHECKING:
    from .compare import Evaluation

Columns = tuple[list[str], Iterable[Sequence[str]]]  # the header of a CSV file, and its rows
REFERENCE = "compensation"  # policy that the others are compared with, motion by motion
SIDEWAYS = "shoulder_abduction"
NOTED = 1.0  # [N·m], additional torque of abduction that is named


def score_table(scores: Sequence[Score], evaluation: "Evaluation | None" = None) -> Rows:
    """Returns one row per policy: effort, relief, torque by joint, tracking and success.

    Args:
        scores: Scores of the policies.
        evaluation: Evaluation that they are from, if it has references.
    """
    header = ["policy", "effort\n[%]"]
    if evaluation is not None:
        header += ["relief,\n95 % interval"]
        if REFERENCE in evaluation.scores:
            header += [f"relief less\n{REFERENCE}'s"]
        header += ["of the\nbound"]
    header += ["abduction/shoulder\n/elbow/wrist [N·m]", "error\n[mrad]", "went\nwell", "reward"]
    return header, [[score.policy, *_cells(score, evaluation)] for score in scores]


def _cells(score: Score, evaluation: "Evaluation | None") -> Iterator[str]:
    yield f"{100 * float(np.mean(score.effort)):.1f}"
    if evaluation is not None:
        relief = evaluation.relief(score.policy)
        ends = "" if relief is None else f"\n{relief.low:.2f} to {relief.high:.2f}"
        yield "-" if relief is None else f"{relief.value:.2f}{ends}"
        if REFERENCE in evaluation.scores:
            free = score.policy not in (*REFERENCES, REFERENCE)
            less = evaluation.relief_difference(score.policy, REFERENCE) if free else None
            yield "-" if less is None else f"{less.value:+.2f}\n{less.low:+.2f} to {less.high:+.2f}"
        share = evaluation.share_of_bound(score.policy)
        yield "-" if share is None else f"{share.value:.0%}"
    yield "/".join(_short(score.human_rms[joint]) for joint in JOINTS)
    yield f"{1e3 * float(np.mean(score.tracking)):.0f}"
    yield f"{np.mean(score.success):.0%}"
    yield f"{np.mean(score.reward):.3f}"


def _short(torque: float) -> str:
    return f"{torque:.1f}" if torque >= 1 else f"{torque:.2f}"


def interval_text(interval: Interval | None) -> str:
    """Returns a value with its interval, or a dash."""
    if interval is None:
        return "-"
    return f"{interval.value:.2f} ({interval.low:.2f} to {interval.high:.2f})"


def effort_table(scores: Sequence[Score]) -> Rows:
    """Returns one row per policy and assisted joint: what a motion costs the wearer."""
    header = ["policy", "joint", "impulse\n[N·m·s]", "work on\nthe arm [J]", "taken\n[J]"]
    header += ["cost of\ntorque", "cost of\nwork [J]", "smoothness\nSPARC"]

    def cells(score: Score, joint: str) -> list[str]:
        cost = score.load[joint]
        return [
            f"{cost['impulse']:.1f}",
            f"{cost['positive_work']:.2f}",
            f"{cost['negative_work']:.2f}",
            f"{cost['torque_cost']:.0f}",
            f"{cost['work_cost']:.1f}",
            f"{cost['spectral_arc_length']:.2f}",
        ]

    return header, _rows(scores, cells)


def _rows(scores: Sequence[Score], cells: Callable[[Score, str], list[str]]) -> list[list[str]]:
    """Returns a row per policy and assisted joint; only a policy's first row has its name."""
    return [
        [
            score.policy if joint == ASSISTED[0] else "",
            joint.removesuffix("_flexion"),
            *cells(score, joint),
        ]
        for score in scores
        for joint in ASSISTED
    ]


def story(evaluation: "Evaluation") -> Iterator[str]:
    """Yields sentences: what suit and exoskeleton cost, and which policies carry the person."""
    cost = evaluation.suit_cost
    if cost is None:
        return
    suited = evaluation.scores["suited"]
    unsuited, in_suit = (
        100 * float(np.mean(evaluation.scores[name].effort)) for name in ("unsuited", "suited")
    )
    yield (
        f"The suit {'raises' if cost.value > 0 else 'lowers'} the wearer's effort from "
        f"{unsuited:.1f} to {in_suit:.1f} % of strength, a change of {100 * cost.value:.1f} "
        f"({100 * cost.low:.1f} to {100 * cost.high:.1f}) points."
    )
    off = evaluation.scores.get("none")
    if off is not None:
        change = 100 * (np.mean(off.effort) - np.mean(suited.effort))
        relief = evaluation.relief("none")
        remark = "" if relief is None else f": relief {interval_text(relief)}"
        yield f"The exoskeleton with its motors off adds {change:.1f} points{remark}."
    yield from _abduction(evaluation)
    reliefs = {name: evaluation.relief(name) for name in evaluation.scores if name != "unsuited"}
    carry = [name for name, one in reliefs.items() if one is not None and one.low > 1]
    if carry:
        yield f"Relief above 1 carries the person too: {', '.join(carry)}."
    if evaluation.relief("suited") is None:
        yield "The suit costs less than 1 % of strength here, so that relief has no meaning."


def _abduction(evaluation: "Evaluation") -> Iterator[str]:
    """Yields what the wearer's shoulder carries because no motor turns it aside."""
    suited = evaluation.scores["suited"].human_rms[SIDEWAYS]
    others = {
        name: score.human_rms[SIDEWAYS]
        for name, score in evaluation.scores.items()
        if name not in REFERENCES
    }
    name = min(others, key=lambda one: others[one], default="")
    if name and others[name] > suited + NOTED:
        yield (
            f"The exoskeleton hangs beside the arm and no motor abducts it: under every policy the "
            f"wearer gives {others[name]:.1f} N·m of abduction or more, and {suited:.1f} N·m "
            "without exoskeleton, one joint of the four that effort is the mean of."
        )


def cuff_remarks(scores: Sequence[Score]) -> list[str]:
    """Returns one sentence per policy with cuffs: the largest forces, and how much one can bear."""
    return [
        f"{score.policy}: cuff forces up to "
        + ", ".join(
            f"{force:.0f} N ({segment.replace('_', ' ')}; at most {FORCE_LIMITS[segment]:.0f})"
            for segment, force in score.cuff_peak.items()
        )
        for score in scores
        if score.cuff_peak
    ]


def guard_remarks(scores: Sequence[Score]) -> list[str]:
    """Returns one sentence per policy with a passivity guard: how much of the time it acted."""
    return [
        f"{score.policy}: the guard acted in {100 * fmean(score.guarded):.2g} % of the time, in "
        f"at most {100 * max(score.guarded):.2g} % of a motion"
        for score in scores
        if score.guarded
    ]


def trace_columns(traces: Mapping[str, Trace]) -> Columns:
    """Returns motions as columns: policy, time [s], angles [rad], torques, strength [N·m], shares.

    Effort, fatigue and the load of a motor are shares of strength, of the muscles, and of the
    continuous torque. A cell is empty where muscles do not tire, or where there are no motors.

    Args:
        traces: Motions by the name of their policy.
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
    """Returns what a trace has over time, by the names of columns."""
    found = {"time_s": trace.time}
    for label, joints, values in (
        ("angle_rad", JOINTS, trace.angle),
        ("target_angle_rad", JOINTS, trace.target_angle),
        ("human_torque_nm", JOINTS, trace.human_torque),
        ("suit_torque_nm", JOINTS, trace.suit_torque),
        ("assist_torque_nm", ASSISTED, trace.assist_torque),
        ("effort", JOINTS, trace.effort),
        ("extensor_strength_nm", JOINTS, trace.strength[:, 0]),
        ("flexor_strength_nm", JOINTS, trace.strength[:, 1]),
        *([] if trace.fatigue is None else [("extensor_fatigue", JOINTS, trace.fatigue[:, 0])]),
        *([] if trace.fatigue is None else [("flexor_fatigue", JOINTS, trace.fatigue[:, 1])]),
        *([] if trace.motor_load is None else [("motor_load", ASSISTED, trace.motor_load)]),
    ):
        found |= {f"{joint}_{label}": values[:, i] for i, joint in enumerate(joints)}
    return found


def units_table(scores: Sequence[Score]) -> Rows:
    """Returns one row per policy: medians over motions of what work is usually measured by."""
    header = ["policy", "above 15 %\n[% of time]", "endurance\n[s]", "hand\nSPARC"]
    header += ["completed\nin [s]", "wrong-way\nassist [J]"]
    rows = []
    for score in scores:
        above, *rest = (_median(values) for values in _units(score))
        rows.append([score.policy, f"{100 * above:.0f}", *map(_known, rest)])
    return header, rows


def _known(value: float) -> str:
    return "-" if np.isnan(value) else f"{round(value, 6):.4g}"


def _median(values: Sequence[float]) -> float:
    known = [value for value in values if not np.isnan(value)]
    return float(np.median(known)) if known else np.nan


UNITS = ("above_limit_share", "endurance_s", "hand_sparc", "completion_s", "wrong_way_work_j")


def _units(score: Score) -> tuple[Sequence[float], ...]:
    return (
        *(score.above_limit, score.endurance, score.smoothness, score.completion),
        score.costs["wrong_way_work"],
    )


def score_columns(scores: Sequence[Score], first_seed: int) -> Columns:
    """Returns a row per policy and motion: effort, torque, tracking, reward, success, strength.

    Names of columns end with their units; a share has the unit 1. Where muscles tire, the fatigued
    part of each joint's at the end of the motion is there.
    """
    joints = [f"{joint}_torque_nm" for joint in JOINTS]
    header = ["policy", "seed", "effort_share", *joints, "tracking_rad", "reward", "success"]
    header += [*UNITS, *(f"{joint}_least_strength_nm" for joint in JOINTS)]
    tired = any(score.fatigued for score in scores)
    header += [f"{joint}_fatigued_share" for joint in JOINTS if tired]
    rows = []
    for score in scores:
        for i, effort in enumerate(score.effort):
            torque = [f"{score.torque[joint][i]:.6g}" for joint in JOINTS]
            rest = [f"{score.tracking[i]:.6g}", f"{score.reward[i]:.6g}", f"{score.success[i]:d}"]
            by_joint = [*score.strength_left.values(), *score.fatigued.values()]
            units = [f"{values[i]:.6g}" for values in (*_units(score), *by_joint)]
            rows.append(
                [score.policy, str(first_seed + i), f"{effort:.6g}", *torque, *rest, *units]
            )
    return header, rows


def outcome(score: Score) -> str:
    """Returns a sentence about one motion: whether it went well, and what it took the wearer."""
    (effort,), (tracking,), (success,) = score.effort, score.tracking, score.success
    end = ", and the arm was lost before its end" if score.failures else ""
    return (
        f"Under {score.policy} the motion {'went well' if success else 'did not go well'}{end}: "
        f"effort {effort:.1%} of strength, tracking error {1e3 * tracking:.0f} mrad."
    )


def relief_plot(evaluation: "Evaluation") -> Plot | None:
    """Returns the relief of each policy with its 95 % interval; None where no relief is known."""
    found = {name: evaluation.relief(name) for name in evaluation.scores if name not in REFERENCES}
    known = {name: one for name, one in found.items() if one is not None}
    if not known:
        return None
    ends = ("value", "low", "high")
    value, low, high = ([getattr(one, end) for one in known.values()] for end in ends)
    marks = [Intervals([*known], value, low, high, color=PALETTE[0])]
    axis = "relief: 0 is the suit alone, 1 is no suit"
    panel = Panel(x=axis, y="", marks=marks)
    height = 1.0 + 0.35 * len(known)
    return Plot(title="Relief, with its 95 % interval", panels=[panel], height=height)
