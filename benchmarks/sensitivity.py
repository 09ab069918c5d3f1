"""What halving and doubling assumed numbers changes: effort, tracking, relief and rankings."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.stats import kendalltau

from ..assets import load_suit
from ..envs.benchmark.suites import SUITE_TASKS
from ..envs.evaluation import FIRST_SEED, REFERENCES
from ..envs.evaluation.relief import relief_interval
from ..envs.evaluation.run import run
from ..envs.evaluation.scores import Score
from ..envs.model import ASSISTED, Exo
from ..envs.person import VoluntaryControl
from ..envs.policies import policy_spec
from ..scripts.output import progress
from ..tables import Rows

SUIT, MOTIONS = "mock-suit", 20
SETTINGS = (
    *(("ArmTracking", "earth"), ("ArmTracking", "microgravity")),
    *(("ReachPanel", "moon"), ("ObjectRelocation", "moon"), ("RangeOfMotion", "earth")),
)
POLICIES = ("none", "feedforward", "compensation", "observer")
NOMINAL = "nominal"
SAME = 0.05  # difference of relief at which two policies have no order
_USUAL = VoluntaryControl()
Scores = dict[str, Score]


@dataclass(frozen=True, kw_only=True)
class Case:
    """The result with one assumed number changed, in one setting.

    Attributes:
        task: Name of the task.
        gravity: Name of the place.
        change: What is changed, such as "control.stiffness x 0.5".
        effort: Mean effort of each policy and reference over strength.
        tracking: Mean tracking error of each of them [rad].
        success: Share of motions that went well, of each of them.
        relief: Relief of each policy; None where the suit costs nothing.
        kendall: Rank correlation of the policies' relief with the nominal one.
        flipped: Conclusions of the docs that are another way round than with the nominal numbers.
    """

    task: str
    gravity: str
    change: str
    effort: dict[str, float]
    tracking: dict[str, float]
    success: dict[str, float]
    relief: dict[str, float] | None
    kendall: float | None
    flipped: tuple[str, ...]

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return asdict(self)


def changes() -> Iterator[tuple[str, dict[str, Any]]]:
    """Yields what is changed, and the options of the environment that it makes."""
    yield NOMINAL, {}
    for name, values in (
        ("stiffness", (0.5, 2.0)),
        ("damping", (_USUAL.damping / 2, 2 * _USUAL.damping)),
        ("contraction", (0.5, 2.0)),
        ("reflex", (_USUAL.reflex / 2, 2 * _USUAL.reflex)),
        ("delay", (0.02, 0.1)),
        ("correction", (_USUAL.correction / 2, 0.8)),
    ):
        for value in values:
            change = f"control.{name} {getattr(_USUAL, name):g} -> {value:g}"
            yield change, {"control": {name: value}}
    exo = Exo()
    for factor in (0.5, 2.0):
        friction = {
            joint.removesuffix("_flexion"): {"coulomb": factor * exo.motors[joint].coulomb}
            for joint in ASSISTED
        }
        yield f"motor.coulomb x {factor:g}", {"exo": friction}
        links = {
            name: factor * getattr(exo, name) for name in ("upper_arm_link", "forearm_link", "ring")
        }
        yield f"exoskeleton's links x {factor:g}", {"exo": links}
        pressure = load_suit(SUIT).pressure_kpa
        if pressure is not None:
            yield f"suit's torque x {factor:g}", {"pressure": factor * pressure}


def sensitivity(motions: int = MOTIONS) -> list[Case]:
    """Runs the policies and the references with each number changed, on the same motions."""
    found = []
    listed = list(changes())
    with progress("changing assumed numbers", len(SETTINGS) * len(listed)) as bar:
        for task, gravity in SETTINGS:
            nominal: Scores | None = None
            for change, options in listed:
                one = _scores(task, gravity, motions, options)
                nominal = nominal or one
                found.append(_case(task, gravity, change, one, nominal))
                bar.advance()
    return found


def _scores(task: str, gravity: str, motions: int, options: dict[str, Any]) -> Scores:
    """Returns the scores of references and policies in the motions of the benchmark."""
    env, seeds = f"ActiveSuit/{task}-v0", range(FIRST_SEED, FIRST_SEED + motions)
    place = {"task": SUITE_TASKS[task], "suit": SUIT, "gravity": gravity, "threads": 0}
    given = {name: name for name in REFERENCES} | {name: policy_spec(name) for name in POLICIES}
    return {
        name: run(name, one, env, seeds, **{**place, **options}).score
        for name, one in given.items()
    }


def _case(task: str, gravity: str, change: str, one: Scores, nominal: Scores) -> Case:
    relief, usual = _relief(one), _relief(nominal)
    agreement = np.nan
    if relief is not None and usual is not None:
        found: Any = kendalltau([usual[p] for p in POLICIES], [relief[p] for p in POLICIES])
        agreement = float(found.statistic)
    here, there = _conclusions(one), _conclusions(nominal)
    return Case(
        task=task,
        gravity=gravity,
        change=change,
        effort={name: float(np.mean(score.effort)) for name, score in one.items()},
        tracking={name: float(np.mean(score.tracking)) for name, score in one.items()},
        success={name: float(np.mean(score.success)) for name, score in one.items()},
        relief=relief,
        kendall=None if np.isnan(agreement) else agreement,
        flipped=tuple(name for name, holds in here.items() if there.get(name, holds) != holds),
    )


def _relief(one: Scores) -> dict[str, float] | None:
    references = [one[name].effort for name in REFERENCES]
    found = {
        name: relief_interval(references[0], references[1], one[name].effort) for name in POLICIES
    }
    if any(relief is None for relief in found.values()):
        return None
    return {name: relief.value for name, relief in found.items() if relief is not None}


def _conclusions(one: Scores) -> dict[str, bool]:
    """Returns which conclusions of the docs hold."""
    relief = _relief(one)
    if relief is None:
        return {"the suit costs effort": False}
    better = {
        f"{first} relieves more than {second}": relief[first] > relief[second] + SAME
        for i, first in enumerate(POLICIES)
        for second in POLICIES[:i]
    }
    return {
        "the suit costs effort": True,
        **{f"{name} is better than no exoskeleton": relief[name] > 0 for name in POLICIES},
        **{
            f"{name} succeeds in most motions": bool(np.mean(one[name].success) > 0.5)
            for name in POLICIES
        },
        **better,
    }


def sensitivity_table(cases: Sequence[Case]) -> Rows:
    """Returns the table of the cases: header and rows."""
    header = ["task", "place", "changed number"]
    header += ["effort none\n[% of strength]", "error none\n[mrad]"]
    header += [f"relief, success\n{name}" for name in POLICIES]
    header += ["rank\ncorrelation", "conclusions that flip"]
    rows = []
    for case in cases:
        relief = [
            f"{'-' if case.relief is None else f'{case.relief[p]:.2f}'}, {case.success[p]:.0%}"
            for p in POLICIES
        ]
        rows.append(
            [
                case.task,
                case.gravity,
                case.change,
                f"{100 * case.effort['none']:.1f}",
                f"{1e3 * case.tracking['none']:.0f}",
                *relief,
                "-" if case.kendall is None else f"{case.kendall:.2f}",
                "; ".join(case.flipped) or "none",
            ]
        )
    return header, rows
