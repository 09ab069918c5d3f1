"""`validate`: controllers that believe suits in arms that wear others, and what suits predict."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import count
from typing import Any

from ...assets import AnySuit, Suit, load_suit
from ...checks import at_least, check_seed, once
from ...errors import InputError
from ...plots import Plot
from ...tables import Rows
from ..model import ASSISTED
from ..policies import policy_spec
from .compare import Evaluation
from .core import FIRST_SEED
from .figures import motion_plots
from .report import score_table, trace_columns
from .rollout import Trace
from .sentences import cuff_remarks, why_remarks
from .statistics import FEWEST_MOTIONS
from .validation import LIMITS, CurveError, Validation, believed_joints, compare_beliefs, verdict
from .validation_report import (
    RULE,
    answer,
    covered_text,
    curve_table,
    matrix_plot,
    matrix_table,
    names_of,
    story,
    torque_table,
)

WEIGHTLESS = "microgravity"  # where only the suit's torque remains
OTHERS = 4  # number of policies and references beside those that believe a suit


@dataclass(frozen=True, kw_only=True)
class SuitValidation:
    """Result of `validate`: what believed suits are worth, each where each plant is simulated.

    Attributes:
        env_id: Id of the environment.
        policy: Policy that believes the suits, with its options.
        motions: Number of motions.
        seed: Seed of the first motion.
        options: Other options of the environment.
        believed: Believed suits, by name.
        plants: Simulated suits, by name.
        cells: Validations, by the names of the believed and of the simulated suit.
        evaluations: Evaluations of all policies, by the name of the simulated suit.
    """

    env_id: str
    policy: str
    motions: int
    seed: int
    options: Mapping[str, Any]
    believed: Mapping[str, AnySuit]
    plants: Mapping[str, AnySuit]
    cells: Mapping[tuple[str, str], Validation]
    evaluations: Mapping[str, Evaluation]

    @property
    def place(self) -> str:
        """Environment, gravity and policy."""
        return f"{self.env_id}, {self.options['gravity']}, {self.policy}"

    @property
    def settings(self) -> dict[str, Any]:
        """What was simulated, as plain values."""
        found = {"env": self.env_id, "policy": self.policy, "motions": self.motions}
        return found | {"seed": self.seed, **self.options, "limits": LIMITS}

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        return {
            **self.settings,
            "cells": [
                {"believed": suit, "plant": true, **one.to_dict()}
                for (suit, true), one in self.cells.items()
            ],
            "evaluations": {true: one.to_dict() for true, one in self.evaluations.items()},
        }

    def tables(self) -> dict[str, Rows]:
        """Returns the matrix of suits, or torque errors and scores of a single pair, by title."""
        if len(self.cells) > 1:
            return {f"Torque error, relief and verdict: {self.place}": matrix_table(self.cells)}
        (((suit, true), found),) = self.cells.items()
        evaluation = self.evaluations[true]
        scores = score_table([*evaluation.scores.values()], evaluation)
        return {
            f"Torque, believed less true: believes {suit}, wears {true}": torque_table(found),
            f"Human torque: {self.place}": scores,
        }

    def sentences(self) -> list[str]:
        """Returns verdict, relief and limits, the most important first."""
        rule = [RULE] * any(one.verdict for one in self.cells.values())
        if len(self.cells) > 1:
            return [covered_text(self.cells), *rule]
        (((suit, true), found),) = self.cells.items()
        believed, evaluation = load_suit(self.believed[suit]), self.evaluations[true]
        drawn = self.options.get("randomize", {}).get("suit") == "samples"
        if found.same and drawn:
            said = answer(found, suit, believed, self.policy, evaluation)
        else:
            said = story(found, suit, believed)
        scores = [*evaluation.scores.values()]
        lacking = _lacking(suit, believed, true, load_suit(self.plants[true]))
        return [*said, *lacking, *why_remarks(scores), *cuff_remarks(scores), *rule]

    def plots(self) -> dict[str, Plot]:
        """Returns the matrix of several suits, and figures of the first motion, by name."""
        matrix = {"matrix": matrix_plot(self.cells)} if len(self.cells) > 1 else {}
        return matrix | motion_plots(self._first)

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
    """Validates suits in closed loop: a controller believes one, and the arm wears another.

    The error of the believed torque along the motions decides the verdict; relief stands beside
    that by the same controller with the true model.

    Args:
        env_id: Id of a registered environment.
        suits: Believed suits: names of shipped ones and paths of files, or suits by your names.
        plants: Simulated suits likewise; by default the one believed suit with its samples, which
            its curves allow too.
        policy: Policy with its options, which believes a suit if it takes the option `suit`.
        samples: Whether each motion draws the suit among the model and the samples of the plant.
        motions: Number of motions, at least 8.
        seed: Seed of the first motion.
        on_step: Function that gets the number of finished motions, and that of all.
        **env_options: Other options of the environment; gravity is "microgravity" by default.

    Raises:
        InputError: A suit resists none of the assisted joints that the true one resists, or has no
            samples that are asked for, or `evaluate` raises it.
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
    for suit in true.values():
        believed_joints(env_id, believed, policy, suit=suit, **options)
    if samples:
        options["randomize"] = {**options.get("randomize", {}), "suit": "samples"}
    total, done = (len(believed) + OTHERS) * len(true) * motions, count()

    def step(_: str, traces: list[Trace]) -> None:
        if on_step:
            on_step((next(done) + 1) * len(traces), total)

    cells, evaluations, labels = {}, {}, names_of(believed)
    same = {"policy": policy, "motions": motions, "seed": seed}
    named = {labels[one]: suit for one, suit in believed.items()}
    for name, suit in true.items():
        more = {"on_policy": step, "threads": 0, "suit": suit, **options}
        evaluations[name], found = compare_beliefs(env_id, named, **same, **more)
        cells |= {(one, name): found[labels[one]] for one in believed}
    kept = {"cells": cells, "evaluations": evaluations, "believed": believed, "plants": true}
    return SuitValidation(env_id=env_id, options=options, **same, **kept)


def _named_suits(given: Sequence[str] | Mapping[str, AnySuit], of: str) -> dict[str, AnySuit]:
    """Returns suits by name; those that cannot be read are refused."""
    if not given:
        raise InputError(f"{of} has no suit: name one that the controller believes")
    if not isinstance(given, Mapping):
        once(of, given)
        given = {name: name for name in given}
    for one in given.values():
        load_suit(one)
    return {**given}


def _itself(believed: Mapping[str, AnySuit]) -> Mapping[str, AnySuit]:
    """Returns the one suit whose samples are the true ones."""
    if len(believed) != 1:
        raise InputError(f"{len(believed)} suits are given and no plant: name the simulated suit")
    ((name, given),) = believed.items()
    joints = load_suit(given).joints
    if not any(joints[one].samples for one in ASSISTED if one in joints):
        raise InputError(
            f"the suit {name!r} has no samples of what its curves allow: identify it again with "
            "--samples 20, or name the simulated suit by --plant"
        )
    return believed


def _lacking(believed: str, suit: Suit, true: str, plant: Suit) -> Iterator[str]:
    """Yields joints that are not assisted, and why."""
    for joint in ASSISTED:
        if joint not in plant.joints:
            yield f"{joint}: nothing to assist, because {true} has no such joint"
        elif joint not in suit.joints:
            yield f"{joint}: not assisted, because {believed} has no such joint"


@dataclass(frozen=True, kw_only=True)
class CurvePrediction:
    """What suits predict of measured curves.

    Attributes:
        errors: Errors of each curve, by suit and joint.
        notes: Curves that test nothing, as sentences.
    """

    errors: Mapping[str, Mapping[str, list[CurveError]]]
    notes: Sequence[str] = ()

    def to_dict(self) -> dict[str, Any]:
        """Returns everything as plain values."""
        found = {
            suit: {
                joint: {"verdict": _worst(errors), "curves": [asdict(one) for one in errors]}
                for joint, errors in by_joint.items()
            }
            for suit, by_joint in self.errors.items()
        }
        return {"limits": LIMITS, "suits": found}

    def tables(self) -> dict[str, Rows]:
        """Returns the errors of all curves, by title."""
        return {"Torque, predicted less measured": curve_table(self.errors)}

    def sentences(self) -> list[str]:
        """Returns the verdict on each joint of each suit."""
        verdicts = [
            f"{suit}, {joint}: {_worst(errors)}"
            for suit, by_joint in self.errors.items()
            for joint, errors in by_joint.items()
        ]
        return [*self.notes, *verdicts, f"{RULE} Of curves, the worst one decides."]


def _worst(errors: Sequence[CurveError]) -> str:
    return verdict(max(error.nrmse for error in errors))
