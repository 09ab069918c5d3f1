"""Validations of suits in sentences: verdict, relief, and limits of both."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...assets import Suit
from ..model import ASSISTED
from .statistics import interval_text, mean_interval

if TYPE_CHECKING:
    from .compare import Evaluation
    from .suit_validation import Validation

LESS = "less than"
TRUE = "true model"  # name of the policy that believes the true suit


def story(found: "Validation", believed: str, suit: Suit) -> Iterator[str]:
    """Yields sentences about a believed suit: verdict with range of angles, limits, relief."""
    nrmse = found.torque.nrmse
    if nrmse is None:
        yield f"{believed}: nothing to judge, as the true suit resists no assisted joint"
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


def answer(
    found: "Validation", believed: str, suit: Suit, policy: str, evaluation: "Evaluation"
) -> Iterator[str]:
    """Yields sentences about the results of a policy with an identified model, and their limits.

    The true suits are the model and the samples of the believed suit, whose name is `believed`.
    """
    joints = {joint: suit.joints[joint] for joint in found.torque.covered}
    nrmse = found.torque.nrmse
    if nrmse is None:
        return
    count = max(len(entry.samples) for entry in joints.values())
    yield _effort_compared(policy, evaluation)
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


def lacking(believed: str, suit: Suit, true: str, plant: Suit) -> Iterator[str]:
    """Yields sentences about joints that are not assisted, and the reasons."""
    for joint in ASSISTED:
        if joint not in plant.joints:
            yield f"{joint}: nothing to assist, because {true} has no such joint"
        elif joint not in suit.joints:
            yield f"{joint}: not assisted, because {believed} has no such joint"


def covered_by(cells: Iterable["Validation"]) -> str:
    """Returns a sentence about the ranges of angles in the motions of all validations."""
    ends: dict[str, list[float]] = {}
    for found in cells:
        for joint, covered in found.torque.covered.items():
            ends.setdefault(joint, []).extend(covered)
    ranges = [f"{joint} {min(one):.2f} to {max(one):.2f} rad" for joint, one in ends.items()]
    return f"The motions covered {', '.join(ranges) or 'no joint that is judged'}."


def _ranges(found: "Validation") -> str:
    """Returns a phrase with the range of angles of the motions, by joint."""
    covered = found.torque.covered.items()
    return ", ".join(f"{joint} from {low:.2f} to {high:.2f} rad" for joint, (low, high) in covered)


def _covered(found: "Validation") -> str:
    return f"the motions cover {_ranges(found)}"


def _beyond(found: "Validation", believed: str, suit: Suit) -> Iterator[str]:
    """Yields sentences about joints that moved beyond the range of their identification."""
    for joint, (low, high) in found.torque.covered.items():
        least, most = suit.joints[joint].range
        if low < least - 0.05 or high > most + 0.05:
            yield f"{believed}, {joint}: identified for {least:.2f} to {most:.2f} rad only"


def _effort_compared(policy: str, evaluation: "Evaluation") -> str:
    """Returns a sentence that compares the effort with that without exoskeleton, and its limit."""
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
    """Returns a phrase that compares two efforts by the 95 % interval of the difference."""
    apart = mean_interval(effort - other)
    return LESS if apart.high < 0 else "more than" if apart.low > 0 else "as much as"
