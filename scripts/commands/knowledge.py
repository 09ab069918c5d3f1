"""`activesuit evaluate knowledge`: what does it buy to know the suit's memory?"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ...arrays import Array
from ...assets import SuitJoint, load_suit
from ...checks import at_least
from ...envs.belief import JointBelief, belief_of
from ...envs.evaluation.knowledge import NONE, Knowledge
from ...envs.evaluation.knowledge import knowledge as evaluate_beliefs
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.model import ASSISTED
from ...envs.rig import RigConfig, run_rig
from ...hysteresis.branches import spring, spring_with_friction, two_branches
from ...identification import Curve, Curves, identify
from ..options import Force, Json, Seed, choice, gravity_option
from ..options import suits as suit_names
from ..options import tasks as task_names
from ..output import Rows, RunFolder, conclude, progress
from ..reports.motions import interval_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STATIC = {
    "spring": spring,
    "spring and friction": spring_with_friction,
    "two branches": two_branches,
}
FITTED = {"MPSO": "mpso", "certified": "certified"}
GRAVITY = "microgravity"  # where nothing but the suit is to be cancelled
TRIALS = 5  # number of trials of MPSO; the best one counts
Found = dict[tuple[str, str], Knowledge]


def knowledge(
    tasks: tuple[Annotated[str, choice(task_names)], ...] = ("MinorLoops", "TransitionCurves"),
    suits: tuple[Annotated[str, choice(suit_names)], ...] = ("mock-suit", "emu-like"),
    gravity: Annotated[str, gravity_option(GRAVITY)] = GRAVITY,
    episodes: int = 20,
    seed: Seed = 0,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Measure how much a hysteresis model improves assistance.

    The shoulder and the elbow of each suit are measured on the simulated rig. Beliefs of rising
    knowledge are fitted to the same curves: none, a spring, a spring with friction, a polynomial
    for each branch, Jiles-Atherton by MPSO, and by the certified fit; last comes the true model.
    All drive the same compensation. By default there is no gravity, which would be most of what
    there is to carry.

    Args:
        tasks: Names of tasks.
        suits: Names or files of the suits that are simulated and measured.
        episodes: Number of motions, at least 8.
        out: Folder for result.json and the figure: a new or an empty one, or that of an earlier
            knowledge.
    """
    at_least("episodes", episodes, FEWEST_MOTIONS)
    at_least("seed", seed, 0)
    folder = RunFolder(out, "knowledge", force=force) if out else None
    found: Found = {}
    with progress("knowledge", len(suits) * (len(tasks) + 1)) as bar:
        for suit in suits:
            beliefs = _beliefs(suit, seed)
            bar.advance()
            for task in tasks:
                found[task, suit] = evaluate_beliefs(
                    f"ActiveSuit/{task}-v0",
                    beliefs,
                    episodes=episodes,
                    suit=suit,
                    gravity=gravity,
                    threads=0,
                )
                bar.advance()
    if folder:
        folder.figure("knowledge", knowledge_figure(found))
    tables = {f"{task}, {suit}": _rows(one) for (task, suit), one in found.items()}
    result = {"gravity": gravity, "episodes": episodes, "seed": seed, "settings": _plain(found)}
    conclude(result, tables, folder=folder, json=json)


def knowledge_figure(found: Found) -> "Figure":
    """Draws relief and torque error of every belief, one panel a setting."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.4 * len(found) + 1.2, 5.2), layout="constrained")
    axes = figure.subplots(2, len(found), squeeze=False, sharex=True, sharey="row")
    for column, ((task, suit), one) in enumerate(found.items()):
        names, place = list(one.relief), np.arange(len(one.relief))
        reliefs = [one.mean_relief(name) for name in names]
        middle = np.array([each.value for each in reliefs])
        ends = np.array([[each.low, each.high] for each in reliefs]).T
        upper, lower = axes[0][column], axes[1][column]
        upper.errorbar(place, middle, np.abs(ends - middle), fmt="o", capsize=3, color="C0")
        upper.axhline(1, color="0.6", linewidth=0.8)
        upper.set_title(f"{task}\n{suit}", fontsize=10)
        lower.bar(place, [one.torque_error[name].mean() for name in names], color="C1")
        lower.set_xticks(place, names, rotation=60, ha="right", fontsize=8)
        for ax in (upper, lower):
            ax.grid(axis="y", alpha=0.3)
    axes[0][0].set_ylabel("relief")
    axes[1][0].set_ylabel("error of the believed\ntorque [N·m]")
    return figure


def _beliefs(suit: str, seed: int) -> dict[str, dict[str, JointBelief]]:
    """Returns beliefs by name and joint, fitted to curves from the rig."""
    true = load_suit(suit)
    joints = [joint for joint in ASSISTED if joint in true.joints]
    curves = {joint: _measured(suit, joint, seed) for joint in joints}
    found: dict[str, dict[str, JointBelief]] = {NONE: {}}
    for name, fit in STATIC.items():
        found[name] = {joint: fit(*_samples(curves[joint])) for joint in joints}
    for name, method in FITTED.items():
        found[name] = {
            joint: belief_of(SuitJoint.from_fit(identify(curves[joint], method=method, seed=seed)))
            for joint in joints
        }
    return found


def _measured(suit: str, joint: str, seed: int) -> Curves:
    """Returns first-order curves of a joint, from the simulated rig."""
    records = run_rig(RigConfig(suit=suit, joint=joint, seed=seed))
    return Curves([Curve(one.angle, one.torque, one.name, time=one.time) for one in records])


def _samples(curves: Curves) -> tuple[Array, Array]:
    """Returns angles and torques of all curves, one after the other."""
    return (
        np.concatenate([curve.angle for curve in curves]),
        np.concatenate([curve.torque for curve in curves]),
    )


def _rows(found: Knowledge) -> Rows:
    header = ["belief", "relief\n(95 % interval)", "more than the\nbelief before"]
    header += ["error of the\ntorque [N·m]", "of its\npeak"]
    rows = []
    for name, errors in found.torque_error.items():
        error = float(np.mean(errors))
        cells = [interval_text(found.mean_relief(name)), interval_text(found.step(name))]
        rows.append([name, *cells, f"{error:.3f}", f"{error / found.peak:.1%}"])
    return header, rows


def _plain(found: Found) -> list[dict[str, Any]]:
    return [
        {
            "task": task,
            "suit": suit,
            "peak": one.peak,
            "relief": one.relief,
            "torque_error": one.torque_error,
        }
        for (task, suit), one in found.items()
    ]
