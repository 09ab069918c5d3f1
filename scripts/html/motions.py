"""Motions of a run: their time series are kept beside the arm, from which the arm is drawn."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import JOINTS
from ...envs.evaluation import Score, Trace
from ...envs.model import ASSISTED
from ...envs.simulation.inverse_dynamics import MASS
from ...envs.simulation.kinematics import hand_jacobian
from ...errors import InputError
from ..folders import RunFolder
from ..reports.motions import write_trace
from .blocks import Block, Chart, Loop, Motion, Player
from .charts import COLORS, GRAY, line, stacked, thinned
from .contents import Contents, KeptMotion
from .series import read_columns

FRAMES = 400  # greatest number of pictures of the arm
RATE = 25.0  # [Hz], of the pictures
TORQUES = ("human_torque_nm", "suit_torque_nm")
FEW = 12  # motions that a page draws
REFERENCES = {"unsuited": (GRAY, "dot"), "suited": (GRAY, "dash")}
# The drawn trunk and head, as shares of the length of the arm: assumed, for the eye alone.
TRUNK, NECK, HEAD = 0.75, 0.1, 0.14


def kept_motion(place: str, policy: str, file: str, trace: Trace) -> dict[str, Any]:
    """Returns what a report has to know of a motion, see `KeptMotion`."""
    arm = trace.arm
    return {
        "place": place,
        "policy": policy,
        "file": file,
        "links": arm.chain.links[0, :, :MASS].tolist(),
        "grip": arm.grip.tolist(),
        "torso": arm.torso.tolist(),
        "turn": arm.turn.tolist(),
    }


def outcome(score: Score) -> str:
    """Returns a sentence about one motion: whether it went well, and what it took the wearer."""
    (effort,), (tracking,), (success,) = score.effort, score.tracking, score.success
    end = ", and the arm was lost before its end" if score.failures else ""
    return (
        f"Under {score.policy} the motion {'went well' if success else 'did not go well'}{end}: "
        f"effort {effort:.1%} of strength, tracking error {1e3 * tracking:.0f} mrad."
    )


def write_motions(
    folder: RunFolder, place: str, traces: Mapping[str, Trace]
) -> list[dict[str, Any]]:
    """Writes motions as trace-1.csv, ...; returns what a report has to know of them.

    Args:
        folder: The run folder.
        place: What was simulated: task, place and suit.
        traces: Motions by the name of their policy.
    """
    kept = []
    for i, (policy, trace) in enumerate(traces.items(), 1):
        write_trace(folder, f"trace-{i}.csv", trace)
        kept.append(kept_motion(place, policy, f"trace-{i}.csv", trace))
    return kept


def motion_blocks(folder: Path, contents: Contents) -> list[Block]:
    """Returns the moving arm with its loops, and angles and torques over time.

    Args:
        folder: The run folder.
        contents: What its report says.
    """
    series = [(one, _series(folder, one)) for one in contents.motions[:FEW]]
    if not series:
        return []
    most = len(contents.motions)
    left_out = f" (the first {FEW} of {most} motions)" if most > FEW else ""
    blocks: list[Block] = [
        Player(
            title=f"The arm and its torque-angle loops{left_out}",
            motions=[_motion(one, columns) for one, columns in series],
        )
    ]
    for place in dict.fromkeys(one.place for one, _ in series):
        here = {one.policy: columns for one, columns in series if one.place == place}
        blocks += [_over_time(place, joint, here) for joint in ASSISTED]
    return blocks


@cache
def _names() -> list[str]:
    labels = ("angle_rad", "target_angle_rad", *TORQUES)
    names = [f"{joint}_{what}" for what in (*labels, "effort") for joint in JOINTS]
    return ["time_s", *names, *(f"{joint}_assist_torque_nm" for joint in ASSISTED)]


def _series(folder: Path, motion: KeptMotion) -> dict[str, Array]:
    found = read_columns(folder, motion.file, (), _names())[1]
    if any(np.isnan(column).any() for column in found.values()):
        raise InputError(f"{folder / motion.file} has empty cells: run the command again")
    return found


def _motion(kept: KeptMotion, series: dict[str, Array]) -> Motion:
    arm = _Arm(kept)
    time = series["time_s"]
    period = max(float(np.median(np.diff(time))), 1e-6) if len(time) > 1 else 1.0
    every = max(1, round(1 / (RATE * period)), -(-len(time) // FRAMES))
    frames = np.arange(0, len(time), every)
    loops = [
        Loop(
            joint=joint,
            angle=series[f"{joint}_angle_rad"],
            torques={
                "suit resistance": -series[f"{joint}_suit_torque_nm"],
                "human torque": series[f"{joint}_human_torque_nm"],
            },
        )
        for joint in ASSISTED
    ]
    return Motion(
        name=f"{kept.policy} ({kept.place})",
        time=time,
        frames=frames,
        places=arm.places(_angles(series, "angle_rad")[frames]),
        intended=arm.places(_angles(series, "target_angle_rad")[frames]),
        body=arm.body(),
        loops=loops,
    )


def _angles(series: dict[str, Array], what: str) -> Array:
    return np.stack([series[f"{joint}_{what}"] for joint in JOINTS], axis=1)


class _Arm:
    """The arm of a kept motion."""

    def __init__(self, kept: KeptMotion) -> None:
        shapes = {"links": (len(JOINTS), MASS), "grip": (3,), "torso": (3,), "turn": (3, 3)}
        found = {}
        for name, shape in shapes.items():
            try:
                found[name] = np.array(getattr(kept, name), dtype=np.float64)
            except ValueError:  # rows of different lengths
                found[name] = np.zeros(0)
            if found[name].shape != shape:
                raise InputError(
                    f"the {name} of the motion {kept.file!r} have another shape than {shape}: "
                    "run the command again"
                )
        self._links, self._grip = found["links"], found["grip"]
        self._torso, self._turn = found["torso"], found["turn"]

    def places(self, angle: Array) -> Array:
        """Returns the places of the joints and the grip in the world [m], (samples, 5, 3)."""
        found = np.empty((len(angle), len(JOINTS) + 1, 3))
        chain = np.empty((len(JOINTS) + 1, 6))
        for sample in range(len(angle)):
            hand_jacobian(self._links, self._grip, angle, sample, chain)
            found[sample, :-1], found[sample, -1] = chain[:-1, 3:], chain[-1, :3]
        return self._in_world(found)

    def body(self) -> Array:
        """Returns places of shoulder, neck, hip and the middle of the head [m], shape (4, 3)."""
        shoulder = self._links[0, :3]
        length = float(np.linalg.norm(np.cumsum(self._links[1:, :3], axis=0)[-1] + self._grip))
        neck = shoulder * [1, 0, 1]
        up = np.array([0.0, 0.0, length])
        return self._in_world(
            np.stack([shoulder, neck, neck - TRUNK * up, neck + (NECK + HEAD) * up])
        )

    def _in_world(self, places: Array) -> Array:
        return self._torso + places @ self._turn.T


def _over_time(place: str, joint: str, here: Mapping[str, dict[str, Array]]) -> Chart:
    """Returns angle, torques and effort of a joint over time, a line per policy."""
    name = joint.replace("_", " ")
    rows = ("angle [rad]", "human torque [N·m]", "suit torque [N·m]", "assist torque [N·m]")
    rows += ("effort [of strength]",)
    columns = ("angle_rad", "human_torque_nm", "suit_torque_nm", "assist_torque_nm", "effort")
    data, colors = [], iter(COLORS * len(here))
    first = next(iter(here.values()))
    kept = thinned(len(first["time_s"]))
    intended = first[f"{joint}_target_angle_rad"][kept]
    data.append(line(first["time_s"][kept], intended, "intended", GRAY, width=5, opacity=0.5))
    for policy, series in here.items():
        kept = thinned(len(series["time_s"]))
        color, dash = REFERENCES.get(policy) or (next(colors), "solid")
        for i, column in enumerate(columns):
            data.append(
                line(
                    series["time_s"][kept],
                    series[f"{joint}_{column}"][kept],
                    policy,
                    color,
                    row=i,
                    group=policy,
                    legend=i == 0,
                    dash=dash,
                )
            )
    return Chart(
        title=f"{name}: {place}",
        text=f"{', '.join(rows)} of the {name} over time, under {', '.join(here)}.",
        data=data,
        layout=stacked(rows, "time [s]"),
    )
