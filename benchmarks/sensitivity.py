"""What halving and doubling assumed numbers changes: effort, tracking, relief and rankings."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.stats import kendalltau

from ..assets import load_suit
from ..envs.evaluation import Evaluation, evaluate
from ..envs.model import ASSISTED, Exo
from ..envs.person import VoluntaryControl
from ..scripts.output import Rows, progress

ENV, SUIT, MOTIONS = "ActiveSuit/ArmTracking-v0", "mock-suit", 20
PLACES = ("earth", "microgravity")
POLICIES = ("none", "gravity", "feedforward", "compensation")
NOMINAL = "nominal"
SAME = 0.05  # difference of relief at which two policies have no order
_USUAL = VoluntaryControl()


@dataclass(frozen=True, kw_only=True)
class Case:
    """The result with one assumed number changed, in one place.

    Attributes:
        gravity: Name of the place.
        change: What is changed, such as "control.stiffness x 0.5".
        effort: Mean effort of each policy and reference over strength.
        tracking: Mean tracking error of each of them [rad].
        relief: Relief of each policy; None where the suit costs nothing.
        kendall: Rank correlation of the policies' relief with the nominal one.
        flipped: Conclusions of the docs that are another way round than with the nominal numbers.
    """

    gravity: str
    change: str
    effort: dict[str, float]
    tracking: dict[str, float]
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
        ("correction", (_USUAL.correction / 2, 2.0)),
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
    """Evaluates four policies and the references with each number changed, on the same motions."""
    found = []
    listed = list(changes())
    with progress("changing assumed numbers", len(PLACES) * len(listed)) as bar:
        for gravity in PLACES:
            nominal: Evaluation | None = None
            for change, options in listed:
                one = evaluate(
                    ENV,
                    POLICIES,
                    episodes=motions,
                    suit=SUIT,
                    gravity=gravity,
                    threads=0,
                    **options,
                )
                nominal = nominal or one
                found.append(_case(gravity, change, one, nominal))
                bar.advance()
    return found


def _case(gravity: str, change: str, one: Evaluation, nominal: Evaluation) -> Case:
    relief, usual = _relief(one), _relief(nominal)
    agreement = np.nan
    if relief is not None and usual is not None:
        found: Any = kendalltau([usual[p] for p in POLICIES], [relief[p] for p in POLICIES])
        agreement = float(found.statistic)
    here, there = _conclusions(one), _conclusions(nominal)
    return Case(
        gravity=gravity,
        change=change,
        effort={name: float(np.mean(score.effort)) for name, score in one.scores.items()},
        tracking={name: float(np.mean(score.tracking)) for name, score in one.scores.items()},
        relief=relief,
        kendall=None if np.isnan(agreement) else agreement,
        flipped=tuple(name for name, holds in here.items() if there.get(name, holds) != holds),
    )


def _relief(one: Evaluation) -> dict[str, float] | None:
    found = {name: one.relief(name) for name in POLICIES}
    if any(relief is None for relief in found.values()):
        return None
    return {name: relief.value for name, relief in found.items() if relief is not None}


def _conclusions(one: Evaluation) -> dict[str, bool]:
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
        **better,
    }


def sensitivity_table(cases: Sequence[Case]) -> Rows:
    """Returns the table of the cases: header and rows."""
    header = ["place", "changed number", "effort none\n[% of strength]", "error none\n[mrad]"]
    header += [f"relief\n{name}" for name in POLICIES]
    header += ["rank\ncorrelation", "conclusions that flip"]
    rows = []
    for case in cases:
        relief = ["-" if case.relief is None else f"{case.relief[p]:.2f}" for p in POLICIES]
        rows.append(
            [
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
