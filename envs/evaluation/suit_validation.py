"""`validate`: controllers that believe suits in arms that wear others, and what that says.

Tables, sentences and figures of what believed suits are worth, and of what suits predict.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np

from ...arrays import Array
from ...assets import AnySuit, Suit, load_suit
from ...checks import at_least, check_seed, once
from ...errors import InputError
from ...plots import Cells as Colored
from ...plots import Panel, Plot
from ...tables import Rows
from ..model import ASSISTED
from ..policies import policy_spec
from .compare import Evaluation
from .core import FIRST_SEED
from .figures import motion_plots
from .report import score_table, trace_columns
from .rollout import Trace
from .sentences import cuff_remarks, why_remarks
from .statistics import FEWEST_MOTIONS, Interval, interval_text, mean_interval
from .validation import (
    LIMITS,
    RULE,
    TRUE,
    TorqueError,
    Validation,
    believed_joints,
    compare_beliefs,
)

Cells = Mapping[tuple[str, str], Validation]  # keys are believed and true suit

LEAST, MOST = 0.01, 0.5  # NRMSE, between which the colors of the matrix change
LESS = "less than"
NOTHING, SAME = "nothing to judge", "the same suit"
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
            return [_covered_by(self.cells), *rule]
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
        given = dict(zip(given, given, strict=True))
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
            "samples (--samples 20), or name the simulated suit (--plant)"
        )
    return believed


def _lacking(believed: str, suit: Suit, true: str, plant: Suit) -> Iterator[str]:
    """Yields joints that are not assisted, and why."""
    for joint in ASSISTED:
        if joint not in plant.joints:
            yield f"{joint}: nothing to assist, because {true} has no such joint"
        elif joint not in suit.joints:
            yield f"{joint}: not assisted, because {believed} has no such joint"


def torque_table(found: Validation) -> Rows:
    """Returns one row per joint, and one of all: the errors of the believed torque."""
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


def matrix_table(cells: Cells) -> Rows:
    """Returns one row per believed suit and one column per true one."""
    labels = names_of(chain(*cells))
    believed, plants = _axes(cells)
    rows = [[labels[one], *(_cell(cells[one, other]) for other in plants)] for one in believed]
    return ["believes", *(f"wears\n{labels[other]}" for other in plants)], rows


def matrix_plot(cells: Cells) -> Plot:
    """Returns a heat map of torque errors; each cell tells error, relief and verdict."""
    header, rows = matrix_table(cells)
    believed, plants = _axes(cells)
    found = [[cells[one, other].torque.nrmse for other in plants] for one in believed]
    errors = np.array([[one.value if one else 0.0 for one in row] for row in found])
    share = np.log(np.clip(errors, LEAST, MOST) / LEAST) / np.log(MOST / LEAST)
    names = [row[0] for row in rows], [name.removeprefix("wears\n") for name in header[1:]]
    marks = [Colored(share, [row[1:] for row in rows], *names)]
    panel = Panel(x="true suit", y="believed suit", marks=marks)
    title = f"Torque error by believed and true suit, green {LEAST:.0%}, red {MOST:.0%} and more"
    return Plot(title=title, panels=[panel], height=1.4 + len(rows))


def story(found: Validation, believed: str, suit: Suit) -> Iterator[str]:
    """Yields sentences about one believed suit: verdict with its range, limits, and relief.

    Args:
        found: Validation of that suit.
        believed: Name of the believed suit.
        suit: The believed suit.
    """
    nrmse = found.torque.nrmse
    if nrmse is None:
        yield f"{believed}: {NOTHING}, as the true suit resists no assisted joint"
    elif found.same:
        yield f"{believed}: no verdict, since it is the true suit too; {_covered(found)}"
    else:
        yield (
            f"{believed}: {found.verdict} for {_ranges(found)}; torque error "
            f"{nrmse.value:.1%} ({nrmse.low:.1%} to {nrmse.high:.1%}) of the peak"
        )
    yield from _beyond(found, believed, suit)
    silent = [joint for joint, noise in found.torque.noise.items() if noise is None]
    if silent:
        yield f"{believed} does not tell how noisy its curves were: {', '.join(silent)}"
    if found.relief is None:
        yield "The suit costs less than 1 % of strength here, so that relief has no meaning."
        return
    yield (
        f"relief {interval_text(found.relief)}, "
        f"{interval_text(found.difference)} beside the true model's; "
        f"{interval_text(found.share_of_true)} of it, and "
        f"{interval_text(found.share_of_bound)} of the best known plan's"
    )


def _ranges(found: Validation) -> str:
    """Returns the angles that the motions covered, by joint."""
    covered = found.torque.covered.items()
    return ", ".join(f"{joint} from {low:.2f} to {high:.2f} rad" for joint, (low, high) in covered)


def _covered(found: Validation) -> str:
    return f"the motions cover {_ranges(found)}"


def _beyond(found: Validation, believed: str, suit: Suit) -> Iterator[str]:
    """Yields joints that moved beyond the range in which they were identified."""
    for joint, (low, high) in found.torque.covered.items():
        least, most = suit.joints[joint].range
        if low < least - 0.05 or high > most + 0.05:
            yield f"{believed}, {joint}: identified for {least:.2f} to {most:.2f} rad only"


def answer(
    found: Validation, believed: str, suit: Suit, policy: str, evaluation: Evaluation
) -> Iterator[str]:
    """Yields how well a controller with an identified model works, and what that leaves out.

    Args:
        found: Validation of the suit where its own model and samples are the true ones.
        believed: Name of the suit.
        suit: The suit.
        policy: Policy that believes it.
        evaluation: Motions of that policy beside those of the references.
    """
    joints = {joint: suit.joints[joint] for joint in found.torque.covered}
    nrmse = found.torque.nrmse
    if nrmse is None:
        return
    count = max(len(entry.samples) for entry in joints.values())
    yield _plain_words(policy, evaluation)
    relief = f"a relief of {interval_text(found.relief)}"
    if found.relief is None:
        relief = "no relief that has a meaning, as the suit costs less than 1 % of strength,"
    yield (
        f"{policy} with this model has {relief} and a torque error of {nrmse.value:.1%} "
        f"({nrmse.low:.1%} to {nrmse.high:.1%}) of the peak, where the true suit is drawn among "
        f"the model and {count} others that its curves allow"
    )
    yield f"no verdict, since a suit says nothing against itself; {_covered(found)}"
    yield from _beyond(found, believed, suit)
    left_open = dict.fromkeys(one for entry in joints.values() for one in entry.left_open)
    yield f"not contained: {'; '.join([*left_open, 'other persons, pressures and tasks'])}"


def _plain_words(policy: str, evaluation: Evaluation) -> str:
    """Returns whether the wearer works less than without exoskeleton, and what limits that."""
    (own,) = (score for name, score in evaluation.scores.items() if name.startswith("by "))
    suited, true = (np.array(evaluation.scores[name].effort) for name in ("suited", TRUE))
    effort = np.array(own.effort)
    text = (
        f"with {policy} and this model the wearer works {_compared(effort, suited)} without "
        f"exoskeleton (effort {effort.mean():.1%} against {suited.mean():.1%} of strength), "
        f"and {_compared(effort, true)} with the true model ({true.mean():.1%})"
    )
    if _compared(true, suited) == LESS:
        return text
    text += ": the limit is the controller and its motors here, not your measurement"
    if evaluation.relief("suited") is None:
        unsuited = float(np.mean(evaluation.scores["unsuited"].effort))
        return f"{text}; there is little to give back, as the effort without suit is {unsuited:.1%}"
    return text if policy == "compensation" else f"{text}; try --policy compensation"


def _compared(effort: Array, other: Array) -> str:
    """Returns how the effort of the same motions compares with another, by its 95 % interval."""
    apart = mean_interval(effort - other)
    return LESS if apart.high < 0 else "more than" if apart.low > 0 else "as much as"


def _covered_by(cells: Cells) -> str:
    """Returns a sentence that names the angles which the motions of all cells covered."""
    ends: dict[str, list[float]] = {}
    for found in cells.values():
        for joint, covered in found.torque.covered.items():
            ends.setdefault(joint, []).extend(covered)
    ranges = [f"{joint} {min(one):.2f} to {max(one):.2f} rad" for joint, one in ends.items()]
    return f"The motions covered {', '.join(ranges) or 'no joint that is judged'}."


def names_of(suits: Iterable[str]) -> dict[str, str]:
    """Returns short names of suits: of a file without its folder, where that is enough."""
    suits = list(dict.fromkeys(suits))
    short = [Path(suit).stem if suit.endswith(".json") else suit for suit in suits]
    return {
        suit: name if short.count(name) == 1 else suit
        for suit, name in zip(suits, short, strict=True)
    }


def _axes(cells: Cells) -> Iterator[list[str]]:
    """Yields the names of the believed suits, then of the true ones."""
    return (list(dict.fromkeys(names)) for names in zip(*cells, strict=True))


def _cell(found: Validation) -> str:
    if found.torque.nrmse is None:
        return NOTHING
    relief = "-" if found.relief is None else f"{found.relief.value:.2f}"
    return f"{found.torque.nrmse.value:.1%}\nrelief {relief}\n{found.verdict or SAME}"
