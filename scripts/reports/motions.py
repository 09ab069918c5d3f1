"""Simulated motions: tables of their scores, remarks on the cuffs, and the trace as CSV."""

from collections.abc import Callable, Collection, Mapping, Sequence

from ...assets import JOINTS
from ...envs.evaluation import Score
from ...envs.model import ASSISTED
from ...envs.model.cuffs import FORCE_LIMITS
from ...envs.rollout import Trace
from ..output import Rows, RunFolder


def score_table(
    scores: Sequence[Score], lacking: Mapping[str, Collection[str]] | None = None
) -> Rows:
    """Returns one row per policy and assisted joint: the wearer's torque, tracking and cost.

    Args:
        scores: Scores of the policies.
        lacking: Joints that the suit which a policy goes by does not have, by policy; their rows
            say so.
    """
    lacking = lacking or {}
    header = ["policy", "joint", "RMS\n[N·m]", "peak\n[N·m]", "RMS\nsaved"]
    header += ["error\n[rad]", "assist\n[J]", "return"]

    def cells(score: Score, joint: str) -> list[str]:
        episode = [f"{score.assist_energy:.1f}", f"{score.mean_return:.0f}"]
        return [
            f"{score.human_rms[joint]:.2f}",
            f"{score.human_peak[joint]:.2f}",
            "-" if score.reduction is None else f"{score.reduction[joint]:.1%}",
            f"{score.tracking_rmse[joint]:.4f}",
            *(episode if joint == ASSISTED[0] else ("", "")),
        ]

    def name(score: Score) -> str:
        return score.policy + (f" ({score.failures} failed)" if score.failures else "")

    rows = _rows(scores, name, cells)
    joints = [(score.policy, joint) for score in scores for joint in ASSISTED]
    for row, (policy, joint) in zip(rows, joints, strict=True):
        row[1] += " (not in suit)" if joint in lacking.get(policy, ()) else ""
    return header, rows


def effort_table(scores: Sequence[Score]) -> Rows:
    """Returns one row per policy and assisted joint: what an episode costs the wearer."""
    header = ["policy", "joint", "impulse\n[N·m·s]", "work on\nthe arm [J]", "taken\n[J]"]
    header += ["cost of\ntorque", "cost of\nwork [J]", "smoothness\nSPARC"]

    def cells(score: Score, joint: str) -> list[str]:
        cost = score.effort[joint]
        return [
            f"{cost['impulse']:.1f}",
            f"{cost['positive_work']:.2f}",
            f"{cost['negative_work']:.2f}",
            f"{cost['torque_cost']:.0f}",
            f"{cost['work_cost']:.1f}",
            f"{cost['spectral_arc_length']:.2f}",
        ]

    return header, _rows(scores, lambda score: score.policy, cells)


def _rows(
    scores: Sequence[Score],
    name: Callable[[Score], str],
    cells: Callable[[Score, str], list[str]],
) -> list[list[str]]:
    """Returns a row per policy and joint; only the first row of a policy has its name."""
    return [
        [
            name(score) if joint == ASSISTED[0] else "",
            joint.removesuffix("_flexion"),
            *cells(score, joint),
        ]
        for score in scores
        for joint in ASSISTED
    ]


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


def write_trace(folder: RunFolder, name: str, trace: Trace) -> None:
    """Writes a trace as CSV: time [s], angles [rad] and torques [N·m] by joint."""
    header = ["time_s"]
    columns = [trace.time[:, None]]
    for label, joints, values in (
        ("angle_rad", JOINTS, trace.angle),
        ("target_angle_rad", JOINTS, trace.target_angle),
        ("human_torque_nm", JOINTS, trace.human_torque),
        ("suit_torque_nm", JOINTS, trace.suit_torque),
        ("assist_torque_nm", ASSISTED, trace.assist_torque),
    ):
        header += [f"{joint}_{label}" for joint in joints]
        columns.append(values)
    rows = zip(*(column for block in columns for column in block.T), strict=True)
    folder.csv(name, header, ([f"{value:.6g}" for value in row] for row in rows))
