"""`validate`: tests of believed suits in closed loop, where the arm wears another suit."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from ...assets import AnySuit, SuitJoint, load_suit
from ...checks import at_least, check_seed, once
from ...errors import InputError
from ...plots import Cells, Panel, Plot
from ...tables import Rows
from ..belief import Belief
from ..domain.levels import NOMINAL
from ..making import make_arms
from ..model import ASSISTED, resisting_joints
from ..policies import AnyPolicy, PolicySpec, make_policy, needed_options, policy_spec
from ..policies.registry import PolicyKind
from .best_known_plan import BOUNDS
from .compare import Evaluation, evaluate
from .figures import motion_plots
from .report import score_table, trace_columns
from .rollout import Trace
from .run import FIRST_SEED
from .sentences import (
    TRUE,
    answer,
    covered_by,
    cuff_remarks,
    lacking,
    validation_story,
    why_remarks,
)
from .statistics import FEWEST_MOTIONS, Interval, interval_text
from .verdict import LIMITS, RULE, TorqueError, TorqueErrors, torque_errors

LEAST, MOST = 0.01, 0.5  # NRMSE at the ends of the color scale of the matrix
WEIGHTLESS = "microgravity"  # the place without torques of weight
OTHERS = 4  # number of policies and references that believe none of the suits
# Options with which the simulated suit is exactly the named suit.
AS_IS = {"pressure": None, "preconditioned": False, "level": NOMINAL}


@dataclass(frozen=True, kw_only=True)
class Validation:
    """The validation of a believed suit where the arm wears a true suit.

    There is no verdict on a suit that is the true suit itself, or of which the true suit is a
    sample: `same` is then True.
    """

    same: bool
    torque: TorqueErrors  # along the motions under the controller that believes the suit
    relief: Interval | None  # of that controller; see `Evaluation.relief`
    difference: Interval | None  # relief less that with the true model, motion by motion
    share_of_true: Interval | None  # relief over that with the true model
    share_of_bound: Interval | None  # relief over that of the best known plan

    @property
    def verdict(self) -> str | None:
        """The verdict by the torque; None if `same`, or without joints."""
        return None if self.same else self.torque.verdict

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values, the verdict first."""
        nrmse = self.torque.nrmse
        return {"verdict": self.verdict, "nrmse": nrmse and nrmse.to_dict(), **asdict(self)}


def with_belief(policy: AnyPolicy, suit: AnySuit) -> PolicySpec:
    """Returns the policy with the option `suit`; a policy without this option is unchanged."""
    spec = policy_spec(policy)
    if "suit" in spec.options:
        raise InputError(
            f"the policy {str(spec)!r} has the option suit: leave the option out, since validate "
            "sets the believed suit"
        )
    if "suit" not in PolicyKind.of(spec.name).options:
        return spec
    return PolicySpec(spec.name, {**spec.options, "suit": suit})


def believed_joints(
    env_id: str, believed: Mapping[str, AnySuit], policy: AnyPolicy, **env_options: Any
) -> dict[str, dict[str, SuitJoint]]:
    """Returns the believed joints of each suit that are assisted and that the true suit has too."""
    arms = make_arms(env_id, 1, **{**env_options, **needed_options(policy)})
    config, found = arms.episodes.simulation.config, {}
    needed = [joint for joint in ASSISTED if joint in resisting_joints(config)]
    for name, suit in believed.items():
        make_policy(with_belief(policy, suit), arms)
        joints = resisting_joints(Belief(suit=suit).of(config))
        found[name] = {joint: joints[joint] for joint in needed if joint in joints}
        if needed and not found[name]:
            raise InputError(
                f"the believed suit {name!r} has no model of {' or '.join(needed)}, which the true "
                "suit has: give a suit with a model of an assisted joint"
            )
    arms.close()
    return found


@dataclass(frozen=True, kw_only=True)
class SuitValidation:
    """Result of `validate`, whose arguments are the first attributes."""

    env_id: str
    policy: str
    motions: int
    seed: int
    options: Mapping[str, Any]
    believed: Mapping[str, AnySuit]  # by name
    plants: Mapping[str, AnySuit]  # simulated suits, by name
    cells: Mapping[tuple[str, str], Validation]  # by the names of believed and simulated suit
    evaluations: Mapping[str, Evaluation]  # of all policies, by the name of the simulated suit

    @property
    def place(self) -> str:
        """Environment, gravity and policy."""
        return f"{self.env_id}, {self.options['gravity']}, {self.policy}"

    @property
    def settings(self) -> dict[str, Any]:
        """Options of the simulation and limits of the verdict, as plain values."""
        found = {"env": self.env_id, "policy": self.policy, "motions": self.motions}
        return found | {"seed": self.seed, **self.options, "limits": LIMITS}

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        cells = [
            {"believed": suit, "plant": true, **one.to_dict()}
            for (suit, true), one in self.cells.items()
        ]
        evaluations = {true: one.to_dict() for true, one in self.evaluations.items()}
        return {**self.settings, "cells": cells, "evaluations": evaluations}

    def tables(self) -> dict[str, Rows]:
        """Returns the matrix of suits, or torque errors and scores of a single pair, by title."""
        if len(self.cells) > 1:
            return {f"Torque error, relief and verdict: {self.place}": self._matrix}
        (((suit, true), found),) = self.cells.items()
        evaluation = self.evaluations[true]
        scores = score_table([*evaluation.scores.values()], evaluation)
        return {
            f"Torque, believed less true: believes {suit}, wears {true}": torque_table(found),
            f"Human torque: {self.place}": scores,
        }

    @property
    def _matrix(self) -> Rows:
        """Rows of believed suits and columns of true suits."""
        labels = names_of(chain(*self.cells))
        rows = [
            [labels[one], *(_cell(self.cells[one, other]) for other in self.plants)]
            for one in self.believed
        ]
        return ["believes", *(f"wears\n{labels[other]}" for other in self.plants)], rows

    def sentences(self) -> list[str]:
        """Returns sentences about verdict, relief and limits, the most important first."""
        rule = [RULE] * any(one.verdict for one in self.cells.values())
        if len(self.cells) > 1:
            return [covered_by(self.cells.values()), *rule]
        (((suit, true), found),) = self.cells.items()
        believed, evaluation = load_suit(self.believed[suit]), self.evaluations[true]
        drawn = self.options.get("randomize", {}).get("suit") == "samples"
        if found.same and drawn:
            said = answer(found, suit, believed, self.policy, evaluation)
        else:
            said = validation_story(found, suit, believed)
        scores = [*evaluation.scores.values()]
        lacks = lacking(suit, believed, true, load_suit(self.plants[true]))
        return [*said, *lacks, *why_remarks(scores), *cuff_remarks(scores), *rule]

    def plots(self) -> dict[str, Plot]:
        """Returns the matrix of several suits, and figures of the first motion, by name."""
        motions = motion_plots(self._first)
        if len(self.cells) == 1:
            return motions
        header, rows = self._matrix
        errors = np.array(
            [
                [nrmse.value if (nrmse := self.cells[one, other].torque.nrmse) else 0.0]
                for one in self.believed
                for other in self.plants
            ]
        ).reshape(len(self.believed), -1)
        share = np.log(np.clip(errors, LEAST, MOST) / LEAST) / np.log(MOST / LEAST)
        names = [row[0] for row in rows], [name.removeprefix("wears\n") for name in header[1:]]
        marks = [Cells(share, [row[1:] for row in rows], *names)]
        panel = Panel(x="true suit", y="believed suit", marks=marks)
        scale = f"green {LEAST:.0%}, red {MOST:.0%} and more"
        title = f"Torque error by believed and true suit, {scale}"
        return {"matrix": Plot(title=title, panels=[panel], height=1.4 + len(rows)), **motions}

    def columns(self) -> dict[str, tuple[Sequence[str], Iterable[Sequence[Any]]]]:
        """Returns header and rows of the first motion, by the name of its CSV file."""
        return {"traces.csv": trace_columns(self._first)}

    @property
    def _first(self) -> dict[str, Trace]:
        """The first motion of each policy in the first plant."""
        return next(iter(self.evaluations.values())).first()


def validate(
    env_id: str,
    suits: Sequence[str] | Mapping[str, AnySuit],
    plants: Sequence[str] | Mapping[str, AnySuit] = (),
    *,
    policy: str = "feedforward",
    samples: bool = False,
    motions: int = 20,
    seed: int = FIRST_SEED,
    on_step: Callable[[int, int], None] | None = None,
    **env_options: Any,
) -> SuitValidation:
    """Validates suits in closed loop: a controller believes a suit, and the arm wears another suit.

    The error of the believed torque along the motions decides the verdict; the relief is compared
    with the relief of the same controller with the true model.

    Args:
        env_id: Id of a registered environment.
        suits: Believed suits: names of shipped suits and paths of files, or suits by your names.
        plants: Simulated suits, given in the same way; by default the one believed suit and its
            samples, which are models that its curves allow too.
        policy: Policy with its options; the policy believes a suit if it has the option `suit`.
        samples: Whether each motion draws the suit among the model and the samples of the plant.
        motions: Number of motions, at least 8.
        seed: Seed of the first motion.
        on_step: Function of the number of finished motions and the number of all motions.
        **env_options: Other options of the environment; gravity is "microgravity" by default.
    """
    believed = _named_suits(suits, "suits")
    if not plants:
        plants, samples = _itself(believed), True
    true = _named_suits(plants, "plants")
    policy_spec(policy)
    at_least("motions", motions, FEWEST_MOTIONS)
    check_seed(seed)
    if "suit" in env_options:
        raise InputError(f"suit is {env_options['suit']!r}: name the simulated suits as plants")
    options: dict[str, Any] = {"gravity": WEIGHTLESS, **env_options}
    joints = {
        name: believed_joints(env_id, believed, policy, suit=suit, **options)
        for name, suit in true.items()
    }
    if samples:
        options["randomize"] = {**options.get("randomize", {}), "suit": "samples"}
    as_is = all(options.get(other, usual) == usual for other, usual in AS_IS.items())
    by = {one: f"by {label}" for one, label in names_of(believed).items()}
    policies: dict[str, Any] = {TRUE: policy, BOUNDS[1]: BOUNDS[1]}
    policies |= {by[one]: with_belief(policy, suit) for one, suit in believed.items()}
    total, done = (len(believed) + OTHERS) * len(true) * motions, 0

    def step(_: str, traces: list[Trace]) -> None:
        nonlocal done
        done += len(traces)
        if on_step:
            on_step(done, total)

    cells, evaluations = {}, {}
    for name, suit in true.items():
        more = {"on_policy": step, "threads": 0, "suit": suit, **options}
        found = evaluations[name] = evaluate(env_id, policies, motions=motions, seed=seed, **more)
        for one, own in by.items():
            cells[one, name] = Validation(
                same=suit == believed[one] and as_is,
                torque=torque_errors(joints[name][one], found.traces[own]),
                relief=found.relief(own),
                difference=found.relief_difference(own, TRUE),
                share_of_true=found.share_of_bound(own, TRUE),
                share_of_bound=found.share_of_bound(own, BOUNDS[1]),
            )
    return SuitValidation(
        env_id=env_id,
        policy=policy,
        motions=motions,
        seed=seed,
        options=options,
        believed=believed,
        plants=true,
        cells=cells,
        evaluations=evaluations,
    )


def _named_suits(given: Sequence[str] | Mapping[str, AnySuit], of: str) -> dict[str, AnySuit]:
    """Returns suits by name, and checks that each can be read."""
    if not given:
        raise InputError(f"{of} has no suit: name at least one")
    if not isinstance(given, Mapping):
        once(of, given)
        given = dict(zip(given, given, strict=True))
    for one in given.values():
        load_suit(one)
    return {**given}


def _itself(believed: Mapping[str, AnySuit]) -> Mapping[str, AnySuit]:
    """Returns the one believed suit, after a check of its samples."""
    if len(believed) != 1:
        raise InputError(f"{len(believed)} suits are given and no plant: name simulated suits")
    ((name, given),) = believed.items()
    joints = load_suit(given).joints
    if not any(joints[one].samples for one in ASSISTED if one in joints):
        raise InputError(
            f"the suit {name!r} has no samples: identify the suit again with samples "
            "(--samples 20), or name the simulated suit (--plant)"
        )
    return believed


def torque_table(found: Validation) -> Rows:
    """Returns the errors of the believed torque: a row per joint, and a row of all joints."""
    header = ["joint", "RMS\n[N·m]", "largest\n[N·m]", "bias\n[N·m]", "late by\n[ms]"]
    header += ["RMS of the\npeak [%]", "over fit\nnoise"]
    rows = []
    for joint, error in found.torque.joints.items():
        noise = found.torque.noise[joint]
        ratio = f"{error.rms.value / noise:.3g}" if noise else "-"
        rows.append([joint.removesuffix("_flexion"), *_errors(error), ratio])
    if found.torque.together:
        rows.append(["together", *_errors(found.torque.together), ""])
    return header, rows


def _errors(error: TorqueError) -> Iterator[str]:
    percent = Interval(*(100 * end for end in vars(error.nrmse).values()))
    sizes = [(one, "z.2f") for one in (error.rms, error.peak, error.bias)]
    for one, form in (*sizes, (error.lag, "z.0f"), (percent, "z.1f")):
        yield interval_text(one, form, lines=True)


def names_of(suits: Iterable[str]) -> dict[str, str]:
    """Returns short names of suits: file names without folder and ending, where these differ."""
    suits = list(dict.fromkeys(suits))
    short = [Path(suit).stem if suit.endswith(".json") else suit for suit in suits]
    pairs = zip(suits, short, strict=True)
    return {suit: name if short.count(name) == 1 else suit for suit, name in pairs}


def _cell(found: Validation) -> str:
    if found.torque.nrmse is None:
        return "nothing to judge"
    relief = "-" if found.relief is None else f"{found.relief.value:.2f}"
    verdict = found.verdict or "the same suit"
    return f"{found.torque.nrmse.value:.1%}\nrelief {relief}\n{verdict}"
