"""What memory of the hysteresis is worth.

The same compensation of a weightless arm is driven by beliefs of the suit without memory (no suit,
a spring, a cubic for each direction) and with memory (Dahl, Jiles-Atherton, Preisach). All beliefs
are fitted to one record of each joint on the simulated rig.

The simulated suit has its own model, of Jiles and Atherton, or a model of Preisach that is fitted
to its records, so that no class of belief is favored. Relief is the share of the suit's cost that
the compensation gives back to adapted wearers, with its 95 % interval; the next column has the
difference from the best belief without memory. The error is the root mean square of the believed
less the true torque. In the figure, beliefs without memory are blue.

Memory pays in this suit, whatever the class of the true model. Two branches do harm although they
know more than the spring, since their torque jumps at each reversal. Another suit or task
(`--suit`, `--task`) can give another answer.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import tyro
from activesuit.arrays import Array
from activesuit.assets import JOINTS, Suit, SuitJoint, load_suit
from activesuit.envs.belief import BelievedSuit, JointBelief, belief_of
from activesuit.envs.evaluation import Evaluation, Interval, Trace, evaluate
from activesuit.envs.model import ASSISTED
from activesuit.envs.model.encoders import count_of
from activesuit.envs.plant import Plant
from activesuit.envs.policies.model_based import SHARE, ModelBased
from activesuit.envs.rig import Record, RigConfig, run_rig
from activesuit.hysteresis.branches import Branches, spring, two_branches
from activesuit.identification import Curve, Curves, fit_curves
from matplotlib.figure import Figure

NONE, TRUE = "no suit", "true model"
WITHOUT_MEMORY = {"spring": spring, "two branches": two_branches}
WITH_MEMORY = {"Dahl": "dahl", "Jiles-Atherton": "jiles-atherton", "Preisach": "preisach"}
REVERSALS = 40  # random ones in the record
GRAVITY = "microgravity"
SAMPLE_RATE = 10.0  # Hz
Beliefs = Mapping[str, Mapping[str, JointBelief]]


def main(
    suit: str = "emu-like",
    task: str = "MinorLoops",
    classes: tuple[str, ...] = ("own", "preisach"),
    motions: int = 20,
    seed: int = 0,
    quick: bool = False,
) -> None:
    """Measures how much relief a memory of the suit's hysteresis buys.

    Args:
        suit: Suit that is simulated and measured.
        task: Task of the wearers.
        classes: Classes of its models in the simulation: its own, or one that is fitted first.
        motions: Number of motions, at least 8.
        seed: Seed of the measurements.
        quick: Few motions of a short task, to see that the program runs.
    """
    models = WITH_MEMORY
    if quick:
        task, classes, motions, models = "ElbowFlexion", ("own",), 8, {"Dahl": "dahl"}
    found = {}
    for kind in classes:
        simulated = of_class(load_suit(suit), kind, seed)
        beliefs = fitted(measured(simulated, seed), models, seed)
        found[simulated.name] = (
            beliefs,
            evaluate(
                f"ActiveSuit/{task}-v0",
                {name: compensation(joints) for name, joints in beliefs.items()}
                | {TRUE: compensation(None)},
                motions=motions,
                suit=simulated,
                gravity=GRAVITY,
            ),
        )
    figure = Figure(figsize=(4.2 * len(found) + 0.8, 6.0), layout="constrained")
    grid = figure.subplots(2, len(found), squeeze=False, sharex=True, sharey="row")
    for axes, (name, (beliefs, evaluation)) in zip(grid.T, found.items(), strict=True):
        traces = evaluation.traces
        errors = {one: torque_error(joints, traces[one]) for one, joints in beliefs.items()}
        print(f"{task}, {motions} motions, {name}, {GRAVITY}\n")
        show(evaluation, {**errors, TRUE: 0.0})
        draw(axes, name, evaluation, {**errors, TRUE: 0.0})
    grid[0, 0].set_ylabel("relief")
    grid[1, 0].set_ylabel("error of the believed torque [N·m]")
    figure.savefig("knowledge.png", dpi=150)


def of_class(suit: Suit, kind: str, seed: int) -> Suit:
    """Returns a suit whose assisted joints have models of a class, fitted to their records."""
    if kind == "own":
        return suit
    joints = dict(suit.joints)
    for joint, record in measured(suit, seed).items():
        joints[joint] = SuitJoint.from_fit(fit_curves(curves(record), model=kind, seed=seed))
    return suit.model_copy(update={"name": f"{suit.name} as {kind}", "joints": joints})


def measured(suit: Suit, seed: int) -> dict[str, Record]:
    """Returns a record of each assisted joint: the largest loop, then random reversals."""
    records = {}
    for joint in ASSISTED:
        rig = RigConfig(suit=suit, joint=joint, sample_rate=SAMPLE_RATE, seed=seed)
        assert rig.start_angle is not None
        low, high = min(rig.start_angle, *rig.turns), max(rig.start_angle, *rig.turns)
        turns = np.random.default_rng(seed).uniform(low, high, REVERSALS)
        (records[joint],) = run_rig(rig, {"loops": [rig.start_angle, high, low, *turns]})
    return records


def curves(record: Record) -> Curves:
    """Returns a record of the rig as `identify` takes it."""
    return Curves([Curve(record.angle, record.torque, record.name, time=record.time)])


def fitted(records: Mapping[str, Record], models: Mapping[str, str], seed: int) -> Beliefs:
    """Returns the beliefs by name and joint."""
    found: dict[str, dict[str, JointBelief]] = {NONE: {}}
    for name, fit in WITHOUT_MEMORY.items():
        found[name] = {
            joint: Memoryless(fit(one.angle, one.torque), one.angle[0])
            for joint, one in records.items()
        }
    for name, model in models.items():
        found[name] = {
            joint: belief_of(SuitJoint.from_fit(fit_curves(curves(one), model=model, seed=seed)))
            for joint, one in records.items()
        }
    return found


@dataclass(frozen=True)
class Memoryless:
    """Curves of both directions as a belief, which remembers the last angle and the direction."""

    curves: Branches
    start_angle: float
    memory_size = 2

    def begin(self) -> Array:
        """Returns the memory at the start, shape (2,)."""
        return np.array([self.start_angle, 1.0])

    def advance(self, memories: Array, angle: Array, soon: Array) -> Array:
        """Moves memories; see `HysteresisModel.advance`."""
        way = np.sign(angle - memories[:, 0])
        memories[:, 1] = np.where(way == 0, memories[:, 1], way)
        memories[:, 0] = angle
        return self.curves.torque(soon, memories[:, 1])


def compensation(joints: Mapping[str, JointBelief] | None) -> Callable[[Plant], ModelBased]:
    """Returns a function that makes the compensation with beliefs; None believes the truth."""

    def made(plant: Plant) -> ModelBased:
        arm = plant.believed()
        suit = arm.suit()
        if joints is not None:
            suit = BelievedSuit(joints, count_of(arm.config.exo.encoder_bits), plant.dt)
        return ModelBased(plant, weight=arm.whole_weight(), suit=suit, friction=SHARE)

    return made


def torque_error(joints: Mapping[str, JointBelief], traces: list[Trace]) -> float:
    """Returns the root mean square of believed less true torque along motions [N·m]."""
    squares = []
    for trace in traces:
        for name in ASSISTED:
            angle = trace.angle[:, JOINTS.index(name)]
            error = trace.suit_torque[:, JOINTS.index(name)].copy()  # minus the true resistance
            if name in joints:
                error += followed(joints[name], angle)
            squares.append(np.mean(error**2))
    return float(np.sqrt(np.mean(squares)))


def followed(belief: JointBelief, angle: Array) -> Array:
    """Returns the believed resistance along a motion [N·m]."""
    memory = belief.begin()[None].copy()
    return np.array([belief.advance(memory, here[None], here[None])[0] for here in angle])


def show(evaluation: Evaluation, errors: Mapping[str, float]) -> None:
    """Prints a row for each belief."""
    best = max((NONE, *WITHOUT_MEMORY), key=lambda name: relief_of(evaluation, name).value)
    print(f"{'belief':16}{'relief':24}{'more than without memory':26}error [N·m]")
    for name, error in errors.items():
        more = "best without memory" if name == best else ""
        if name not in (NONE, *WITHOUT_MEMORY):
            more = shown(evaluation.relief_difference(name, best))
        print(f"{name:16}{shown(relief_of(evaluation, name)):24}{more:26}{error:11.2f}")
    print()


def relief_of(evaluation: Evaluation, name: str) -> Interval:
    """Returns the relief of a belief."""
    found = evaluation.relief(name)
    assert found, "the suit costs too little: choose another suit or task"
    return found


def shown(one: Interval | None) -> str:
    """Returns an interval with two decimals."""
    return f"{one.value:.2f} ({one.low:.2f} to {one.high:.2f})" if one else ""


def draw(axes: Any, title: str, evaluation: Evaluation, errors: Mapping[str, float]) -> None:
    """Draws the reliefs above, the errors of the torque below."""
    upper, lower = axes
    for place, (name, error) in enumerate(errors.items()):
        one = relief_of(evaluation, name)
        color = "C0" if name in (NONE, *WITHOUT_MEMORY) else "C1"
        ends = [[one.value - one.low], [one.high - one.value]]
        upper.errorbar(place, one.value, ends, fmt="o", capsize=4, color=color)
        lower.bar(place, error, color=color)
    upper.axhline(0, color="0.6", linewidth=0.8)
    upper.set_title(title)
    lower.set_xticks(range(len(errors)), list(errors), rotation=45, ha="right")
    for ax in axes:
        ax.grid(axis="y", alpha=0.3)


if __name__ == "__main__":
    tyro.cli(main)
