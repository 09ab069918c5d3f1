"""`activesuit evaluate knowledge`: what does it buy to know the suit's memory?"""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ...assets import Suit, SuitJoint, load_suit
from ...checks import at_least, check_seed, once
from ...envs.belief import JointBelief, belief_of
from ...envs.evaluation.knowledge import NONE, Knowledge
from ...envs.evaluation.knowledge import knowledge as evaluate_beliefs
from ...envs.evaluation.statistics import FEWEST_MOTIONS
from ...envs.model import ASSISTED
from ...envs.rig import Record, RigConfig, run_rig
from ...errors import unknown_name
from ...hysteresis.branches import spring, spring_with_friction, two_branches
from ...identification import Curve, Curves, Search, identify
from ...identification.fits.registry import FITS
from ..conclusion import conclude
from ..options import Force, Json, Seed, choice, gravity_option
from ..options import suits as suit_names
from ..options import tasks as task_names
from ..output import Rows, RunFolder, progress
from ..reports.motions import interval_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OWN = "own"  # class of model that a suit file has
TRIALS = 5  # number of trials of MPSO; the best one counts
WITHOUT_MEMORY = {
    "spring": spring,
    "spring and friction": spring_with_friction,
    "two branches": two_branches,
    "map of angle and direction": partial(two_branches, degree=7),
}
WITH_MEMORY = {
    "Dahl": {"model": "dahl"},
    "Prandtl-Ishlinskii": {"model": "prandtl-ishlinskii"},
    "Preisach": {"model": "preisach"},
    "Bouc-Wen": {"model": "bouc-wen"},
    "Jiles-Atherton by MPSO": {"method": Search("mpso", trials=TRIALS)},
    "Jiles-Atherton": {},
}
REVERSALS = 40  # random ones in the record to which all beliefs are fitted
THINNED = 4  # every fourth sample is used where a fit takes all of them
GRAVITY = "microgravity"  # where nothing but the suit is to be cancelled
COLUMNS = 4  # panels beside each other in the figure
Found = dict[tuple[str, str], Knowledge]


def knowledge(
    tasks: tuple[Annotated[str, choice(task_names)], ...] = ("MinorLoops", "TransitionCurves"),
    suits: tuple[Annotated[str, choice(suit_names)], ...] = ("mock-suit", "emu-like"),
    classes: tuple[Annotated[str, choice(lambda: (OWN, *FITS))], ...] = (OWN, "preisach"),
    gravity: Annotated[str, gravity_option(GRAVITY)] = GRAVITY,
    episodes: int = 20,
    seed: Seed = 0,
    out: Path | None = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Measure how much a hysteresis model improves assistance.

    The shoulder and the elbow of each suit are measured on the simulated rig: the largest loop, and
    minor loops between random reversals. Beliefs are fitted to that record: without memory (none, a
    spring, a spring with friction, a cubic or a polynomial of degree 7 for each direction), with
    one state of memory (Dahl, Bouc-Wen, Jiles-Atherton) and with many (Prandtl-Ishlinskii,
    Preisach). Last comes the true model. All drive the same compensation. By default there is no
    gravity, which would be most of what there is to carry.

    Args:
        tasks: Names of tasks.
        suits: Names or files of the suits that are simulated and measured.
        classes: Classes of their models: their own, or another one that is first fitted to a record
            of their own and then takes their place.
        episodes: Number of motions, at least 8.
        out: Folder for result.json and the figure: a new or an empty one, or that of an earlier
            knowledge.
    """
    at_least("episodes", episodes, FEWEST_MOTIONS)
    check_seed(seed)
    folder = RunFolder(out, "knowledge", force=force) if out else None
    found: Found = {}
    once("classes", classes)
    for kind in classes:
        if kind not in (OWN, *FITS):
            raise unknown_name("class", kind, (OWN, *FITS))
    simulated = [_of_class(suit, kind, seed) for suit in suits for kind in classes]
    with progress("knowledge", len(simulated) * (len(tasks) + 1)) as bar:
        for suit in simulated:
            beliefs = _beliefs(suit, seed)
            bar.advance()
            for task in tasks:
                found[task, suit.name] = evaluate_beliefs(
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

    columns = min(len(found), COLUMNS)
    bands = -(-len(found) // columns)
    figure = Figure(figsize=(3.4 * columns + 1.2, 3.6 * bands + 1.6), layout="constrained")
    axes = figure.subplots(2 * bands, columns, squeeze=False, sharex=True)
    for index, ((task, suit), one) in enumerate(found.items()):
        band, column = divmod(index, columns)
        names, place = list(one.relief), np.arange(len(one.relief))
        reliefs = [one.mean_relief(name) for name in names]
        middle = np.array([each.value for each in reliefs])
        ends = np.array([[each.low, each.high] for each in reliefs]).T
        upper, lower = axes[2 * band : 2 * band + 2, column]
        upper.errorbar(place, middle, np.abs(ends - middle), fmt="o", capsize=3, color="C0")
        upper.axhline(1, color="0.6", linewidth=0.8)
        upper.set_title(f"{task}\n{suit}", fontsize=10)
        lower.bar(place, [one.torque_error[name].mean() for name in names], color="C1")
        lower.set_xticks(place, names, rotation=60, ha="right", fontsize=8)
        for ax in (upper, lower):
            ax.grid(axis="y", alpha=0.3)
    for ax in axes.flat[len(found) + columns * bands :]:
        ax.set_axis_off()
    for upper, lower in zip(axes[::2, 0], axes[1::2, 0], strict=True):
        upper.set_ylabel("relief")
        lower.set_ylabel("error of the believed\ntorque [N·m]")
    return figure


def _of_class(name: str, kind: str, seed: int) -> Suit:
    """Returns a suit whose assisted joints have models of a class, fitted to records of theirs."""
    suit = load_suit(name)
    if kind == OWN:
        return suit
    joints = dict(suit.joints)
    for joint, one in _records(suit, seed).items():
        joints[joint] = SuitJoint.from_fit(identify(_curves(one), model=kind, seed=seed))
    return suit.model_copy(update={"name": f"{suit.name} as {kind}", "joints": joints})


def _beliefs(suit: Suit, seed: int) -> dict[str, dict[str, JointBelief]]:
    """Returns beliefs by name and joint, fitted to a record from the rig."""
    records = _records(suit, seed)
    found: dict[str, dict[str, JointBelief]] = {NONE: {}}
    for name, fit in WITHOUT_MEMORY.items():
        found[name] = {
            joint: fit(one.angle[::THINNED], one.torque[::THINNED])
            for joint, one in records.items()
        }
    for name, options in WITH_MEMORY.items():
        found[name] = {}
        for joint, one in records.items():
            fit = identify(_curves(one), **options, seed=seed)
            found[name][joint] = belief_of(SuitJoint.from_fit(fit))
    return found


def _curves(record: Record) -> Curves:
    return Curves([Curve(record.angle, record.torque, record.name, time=record.time)])


def _records(suit: Suit, seed: int) -> dict[str, Record]:
    """Returns records of the assisted joints from the rig: the largest loop, then minor loops."""
    return {joint: _measured(suit, joint, seed) for joint in ASSISTED if joint in suit.joints}


def _measured(suit: Suit, joint: str, seed: int) -> Record:
    config = RigConfig(suit=suit, joint=joint, seed=seed)
    start = config.specimen().start_angle if config.start_angle is None else config.start_angle
    low, high = min(start, *config.turns), max(start, *config.turns)
    turns = np.random.default_rng(seed).uniform(low, high, REVERSALS)
    return run_rig(config, {"loops": [start, high, low, *turns]})[0]


def _rows(found: Knowledge) -> Rows:
    header = ["belief", "relief\n(95 % interval)", "more than the best\nwithout memory"]
    header += ["error of the\ntorque [N·m]", "of its\npeak"]
    rows = []
    for name, errors in found.torque_error.items():
        error = float(np.mean(errors))
        cells = [interval_text(found.mean_relief(name)), interval_text(found.gain(name))]
        rows.append([name, *cells, f"{error:.3f}", f"{error / found.peak:.1%}"])
    return header, rows


def _plain(found: Found) -> list[dict[str, Any]]:
    return [
        {
            "task": task,
            "suit": suit,
            "peak": one.peak,
            "without_memory": list(one.without_memory),
            "best_without_memory": one.best_without_memory,
            "beliefs": {name: _believed(one, name) for name in one.relief},
        }
        for (task, suit), one in found.items()
    ]


def _believed(found: Knowledge, belief: str) -> dict[str, Any]:
    gain = found.gain(belief)
    return {
        "mean_relief": found.mean_relief(belief).to_dict(),
        "gain": gain and gain.to_dict(),
        "relief": found.relief[belief],
        "torque_error": found.torque_error[belief],
    }
