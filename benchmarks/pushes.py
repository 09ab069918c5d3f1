"""Pushes on a held arm: the usual wearer and a persistent one, behind the gears and bare.

The command of the motors is frozen. Shoulder and elbow are pushed by steps and by pulses of torque,
in cases that differ in posture, person, control, load, suit and place. None of these cases was used
to choose the law of the persistent wearer. Learned motions follow, with their effort.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arrays import Array
from ..assets import JOINTS
from ..envs.evaluation import FIRST_SEED
from ..envs.evaluation.run import run
from ..envs.policies import PolicySpec, make_policy
from ..envs.simulation.measurements import ANGLE, HUMAN
from ..envs.tasks import RandomMoves
from ..envs.vector_env import ArmVectorEnv
from ..scripts.output import progress
from ..tables import Rows

BEGIN, SECOND, PERIODS = 100, 100, 500  # control periods: start of a push, 1 s, all
PULSE = {"rigid": 30, "cuffs": 30, "none": 10}  # control periods of a pulse
USUAL, OTHER, BENT = (0.0, 0.6, 1.2, 0.0), (0.2, 0.9, 0.7, 0.1), (0.0, 0.3, 1.5, 0.0)  # rad
PUSHED = ("shoulder_flexion", "elbow_flexion")
PUSH, GREATER, BACK = (4.0, 3.0), (5.0, 4.0), (-4.0, -3.0)  # [N·m], shoulder and elbow
NEAR, QUIET, SWINGS = 0.012, 0.004, 2  # rad, rad, count: limits of a good answer
WOMAN = {"sex": "female", "stature": 1.66, "mass": 72.0}
BEHIND: tuple[dict[str, Any], ...] = (
    {"posture": OTHER},
    {"posture": BENT, "push": BACK},
    {"push": GREATER},
    {"control": {"stiffness": 0.65}},
    {"control": {"stiffness": 1.6}, "posture": OTHER},
    {"control": {"damping": 0.065}, "push": BACK},
    {"control": {"damping": 0.16}, "posture": BENT},
    {"wearer": WOMAN, "posture": OTHER},
    {"wearer": {"stature": 1.70, "mass": 62.0}, "push": BACK},
    {"gravity": "moon", "payload": {"mass": 3.0}, "posture": OTHER},
    {"coupling": "cuffs", "payload": {"mass": 1.5}, "posture": BENT},
    {"suit": "exploration-56kpa", "push": GREATER},
    {"suit": "emu-like", "gravity": "moon", "push": BACK},
)
ALONE: tuple[dict[str, Any], ...] = (
    *BEHIND[:6],
    {"wearer": WOMAN, "posture": OTHER},
    {"payload": {"mass": 4.0}, "posture": OTHER},
    {"payload": {"mass": 2.5}, "control": {"stiffness": 0.8}},
    {"gravity": "moon", "payload": {"mass": 4.0}, "push": BACK},
)
MOTIONS = 8
LEARNED = (
    ("ArmTracking", "mock-suit", "microgravity"),
    ("ArmTracking", "emu-like", "moon"),
    ("ReachPanel", "mock-suit", "moon"),
    ("ObjectRelocation", "mock-suit", "moon"),
)


def answers(
    persistent: bool,
    *,
    posture: tuple[float, ...] = USUAL,
    push: tuple[float, float] = PUSH,
    control: Mapping[str, float] | None = None,
    gravity: str = "microgravity",
    **options: Any,
) -> list[dict[str, Any]]:
    """Returns the answers to a step and to a pulse at the shoulder, then at the elbow."""
    task = RandomMoves(
        name="Held",
        hold={joint: (angle, angle) for joint, angle in zip(JOINTS, posture, strict=True)},
        duration=6.0,
    )
    given = {"adaptation": 0.0, "persistent": persistent, **(control or {})}
    arms = ArmVectorEnv(5, task, control=given, gravity=gravity, **options)
    observation, _ = arms.reset(seed=[1] * 5)
    simulation = arms.episodes.simulation
    friction = simulation.state.wearer.feedback.persistence.friction
    action = make_policy("compensation" if friction.any() else "none", arms).act(observation)
    applied, courses = simulation.batch.bind("qfrc_applied"), []
    at = [JOINTS.index(joint) for joint in PUSHED for _ in range(2)]
    lasts = [PERIODS, PULSE[options.get("coupling", "rigid")]] * 2
    for period in range(PERIODS):
        for row, j in enumerate(at):
            on = BEGIN <= period < BEGIN + lasts[row]
            applied[row + 1, simulation.addresses.joints[j]] = push[row // 2] * on
        arms.step(action)
        measured = simulation.state.sensors.measured
        courses.append(measured[:, [*range(ANGLE, ANGLE + 4), *range(HUMAN, HUMAN + 4)]].copy())
    arms.close()
    change = np.array(courses)[BEGIN:]
    change -= change[:, :1]
    found = []
    for row, j in enumerate(at):
        way, held = np.sign(push[row // 2]), abs(push[row // 2]) + friction[j]
        answer = _answer(way * change[:, row + 1, j])
        found.append({**answer, "torque": float((-way * change[:, row + 1, 4 + j]).max() / held)})
    return found


def _answer(away: Array) -> dict[str, Any]:
    """Returns what is left of a displacement [rad] after a second, its end, and whether good."""
    farthest = int(np.argmax(np.abs(away)))
    peak, left = float(np.abs(away).max()), float(abs(away[SECOND]))
    sides = np.sign(away[farthest:][np.abs(away[farthest:]) > NEAR])
    end, swings = float(away[-150:].std()), int(np.count_nonzero(np.diff(sides)))
    good = left <= max(peak / 3, NEAR) and end < QUIET and swings <= SWINGS
    return {"left": left / peak, "end": end, "swings": swings, "good": good}


def pushes() -> list[dict[str, Any]]:
    """Returns a summary of the answers, usual and persistent, and the cost in learned motions."""
    summaries = []
    with progress("pushing", 2 * (len(BEHIND) + len(ALONE) + len(LEARNED))) as bar:
        for persistent in (False, True):
            row: dict[str, Any] = {"persistent": persistent}
            for name, cases in (("behind", BEHIND), ("bare", ALONE)):
                bare: dict[str, Any] = (
                    {} if name == "behind" else {"coupling": "none", "suit": "none"}
                )
                found = []
                for case in cases:
                    found += answers(persistent, **case, **bare)
                    bar.advance()
                steps = found[0::2]
                row[name] = {
                    "answers": len(found),
                    "good": sum(one["good"] for one in found),
                    "left": float(np.median([one["left"] for one in found])),
                    "torque": max(one["torque"] for one in steps),
                    "end": max(one["end"] for one in found),
                }
            row["learned"] = {}
            for task, suit, place in LEARNED:
                score = run(
                    "compensation",
                    PolicySpec("compensation"),
                    f"ActiveSuit/{task}-v0",
                    range(FIRST_SEED, FIRST_SEED + MOTIONS),
                    suit=suit,
                    gravity=place,
                    control={"persistent": persistent},
                ).score
                row["learned"][f"{task}, {suit}, {place}"] = {
                    "successes": sum(score.success),
                    "strength": float(np.mean(score.effort)),
                    "hand": float(np.mean(score.costs["hand_error"])),
                }
                bar.advance()
            summaries.append(row)
    return summaries


def pushes_table(found: list[dict[str, Any]]) -> Rows:
    """Returns the table: header and rows."""
    rows = []
    for name, label in (("behind", "behind gears"), ("bare", "bare arm")):
        parts = [one[name] for one in found]
        rows += [
            [f"{label}: good answers", *[f"{one['good']} of {one['answers']}" for one in parts]],
            ["left after 1 s, median", *[f"{one['left']:.0%}" for one in parts]],
            [
                "most torque of a step, over push and friction",
                *[f"{p['torque']:.2f}" for p in parts],
            ],
            ["worst unrest in the end [mrad]", *[f"{1e3 * one['end']:.1f}" for one in parts]],
        ]
    for name in found[0]["learned"]:
        parts = [one["learned"][name] for one in found]
        cells = [
            f"{one['successes']} of {MOTIONS}, {one['strength']:.2%}, {1e3 * one['hand']:.0f} mm"
            for one in parts
        ]
        rows.append([f"{name}: success, effort, hand error", *cells])
    return ["", "usual wearer", "persistent wearer"], rows
