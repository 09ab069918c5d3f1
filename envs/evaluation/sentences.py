"""Evaluations and validations in sentences.

Evaluations: costs of suit and policies, and reasons why motions failed. Validations of suits:
verdict, relief, and limits of both.
"""

from collections.abc import Iterable, Iterator, Sequence
from statistics import fmean
from typing import TYPE_CHECKING

import numpy as np

from ...arrays import Array
from ...assets import Suit
from ..model import ASSISTED
from ..model.cuffs import FORCE_LIMITS
from .reasons import Frequent, most_frequent
from .scores import REFERENCES, Score
from .statistics import interval_text, mean_interval

if TYPE_CHECKING:
    from .compare import Evaluation
    from .suit_validation import Validation

SIDEWAYS = "shoulder_abduction"
NOTED = 1.0  # [N·m], least additional torque of abduction with a sentence
LEAST = 0.01  # least share of time at the peak torque with a sentence
LESS = "less than"
TRUE = "true model"  # name of the policy that believes the true suit
# Words for a limit, the factor of its numbers, their unit, and the limit's name in a sentence; only
# limits with such a name can be exceeded by an arm without motors.
_WORDS = {
    "worst_joint": ("{part}", 1e3, "mrad", "tracking"),
    "effort": ("effort", 100, "%", "effort"),
    "hand_error": ("hand", 1e3, "mm", "the hand's place"),
    "tilt": ("tilt of the hand", 1e3, "mrad", "the hand's tilt"),
    "slowness": ("hand too slow by", 100, "%", "the hand's speed"),
    "cuff_force": ("force of the {part} cuff", 100, "% of what a person bears", None),
    "heat": ("load of the {part} motor", 100, "% of continuous", None),
    "lost": ("arm lost", 1, "", "the arm's range"),
}


def motion_remarks(found: "Evaluation") -> Iterator[str]:
    """Yields sentences about a drawn seed, policies that are not apart, and equal motions."""
    if found.drawn:
        yield (
            f"the motions have the seeds from {found.first_seed}, drawn after the policies were "
            f"given; seed {found.first_seed} repeats them"
        )
    if not found.apart:
        yield "policies of your own had no processes of their own, so that they may have rehearsed"
    score = next(iter(found.scores.values()))
    if score.distinct < len(score.motion):
        yield (
            f"{len(score.motion)} motions are {score.distinct} different ones: intervals are over "
            "these"
        )


def why_remarks(scores: Sequence[Score]) -> Iterator[str]:
    """Yields a sentence for each policy with failed motions, frequent reasons first.

    With the score of the suited arm, a second sentence names the limits that the policy exceeds and
    the suited arm without assistance keeps in the same motions.
    """
    suited = next((one for one in scores if one.policy == REFERENCES[1]), None)
    for one in scores:
        failed = one.success.count(False)
        if failed:
            of = f" in {failed} of {len(one.success)} motions" if len(one.success) > 1 else ""
            parts = [
                exceeded(why) + (f" ({motions_text(why.motions)})" if why.motions < failed else "")
                for why in most_frequent(one.why)
            ]
            yield f"{one.policy} failed{of}: {'; '.join([*parts, *_hot(one)])}"
            kept = _kept_unassisted(one, suited) if suited else []
            if kept and one.policy not in REFERENCES:
                limits = "this limit" if len(kept) == 1 else "these limits"
                yield (
                    f"{one.policy}: without assistance the same motions stay within {limits}: "
                    f"{', '.join(kept)}"
                )


def _kept_unassisted(score: Score, suited: Score) -> list[str]:
    """Returns words for limits that the policy exceeds where the suited arm keeps the limits."""
    mine, both = set[str](), set[str]()
    for why, theirs in zip(score.why, suited.why, strict=True):
        names = {reason.name for reason in why}
        mine |= names
        both |= names & {reason.name for reason in theirs}
    return [named for name, (*_, named) in _WORDS.items() if named and name in mine - both]


def motions_text(count: int) -> str:
    """Returns a number of motions in words."""
    return "1 motion" if count == 1 else f"{count} motions"


def exceeded(why: Frequent) -> str:
    """Returns a phrase with median size and time of the excess over a limit."""
    part = (why.part or "").removesuffix("_flexion").replace("_", " ")
    if why.name == "lost":
        return f"arm lost at {why.time_s:.1f} s ({part})"
    words, factor, unit, _ = _WORDS[why.name]
    size = f"{_number(factor * why.value)} {unit} of {_number(factor * why.limit)}"
    said = f"{words.format(part=part)} {size} from {why.time_s:.1f} s"
    if why.oscillation is None:
        return said
    period, amplitude = why.oscillation.period_s, _number(factor * why.oscillation.amplitude)
    return f"{said}, oscillates with a period of {period:.2g} s, amplitude {amplitude} {unit}"


def _number(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _hot(score: Score) -> Iterator[str]:
    """Yields phrases about motors that were hot, or gave their peak torque, in failed motions."""
    bad = ~np.array(score.success)
    for joint, times in score.hot_from.items():
        hot = np.array(times)[bad]
        name = joint.removesuffix("_flexion")
        if np.isfinite(hot).any():
            yield f"{name} motor hot from {np.median(hot[np.isfinite(hot)]):.1f} s"
        full = np.array(score.saturated[joint])[bad]
        if full.max() >= LEAST:
            yield f"{name} motor at its peak in {100 * np.median(full):.0f} % of the time"


def story(evaluation: "Evaluation") -> Iterator[str]:
    """Yields sentences about the cost of suit and exoskeleton, and policies with relief above 1."""
    cost = evaluation.suit_cost
    if cost is None:
        return
    unsuited, suited = (100 * float(np.mean(evaluation.scores[name].effort)) for name in REFERENCES)
    yield (
        f"The suit {'raises' if cost.value > 0 else 'lowers'} the wearer's effort from "
        f"{unsuited:.1f} to {suited:.1f} % of strength, a change of {100 * cost.value:.1f} "
        f"({100 * cost.low:.1f} to {100 * cost.high:.1f}) points."
    )
    off = evaluation.scores.get("none")
    if off is not None:
        change = 100 * float(np.mean(off.effort)) - suited
        relief = evaluation.relief("none")
        remark = "" if relief is None else f": relief {interval_text(relief)}"
        yield f"The exoskeleton with its motors off adds {change:.1f} points{remark}."
    yield from _abduction(evaluation)
    reliefs = {name: evaluation.relief(name) for name in evaluation.scores if name != "unsuited"}
    carry = [name for name, one in reliefs.items() if one is not None and one.low > 1]
    if carry:
        yield f"Relief above 1 carries the person too: {', '.join(carry)}."
    if evaluation.relief("suited") is None:
        yield "The suit costs less than 1 % of strength here, so that relief has no meaning."


def _abduction(evaluation: "Evaluation") -> Iterator[str]:
    """Yields a sentence about the torque of shoulder abduction, which has no motor."""
    torque = {name: one.human_rms[SIDEWAYS] for name, one in evaluation.scores.items()}
    suited = torque["suited"]
    least = min((one for name, one in torque.items() if name not in REFERENCES), default=0.0)
    if least > suited + NOTED:
        yield (
            "No motor carries the exoskeleton in shoulder abduction, which is one of the four "
            f"joints in effort: the wearer's torque of abduction is {least:.1f} N·m or more under "
            f"every policy, and {suited:.1f} N·m without exoskeleton."
        )


def cuff_remarks(scores: Sequence[Score]) -> Iterator[str]:
    """Yields a sentence for each policy with cuffs: the largest forces and the limits of force."""
    for score in scores:
        forces = [
            f"{force:.0f} N ({segment.replace('_', ' ')}; at most {FORCE_LIMITS[segment]:.0f})"
            for segment, force in (score.cuff_peak or {}).items()
        ]
        if forces:
            yield f"{score.policy}: cuff forces up to {', '.join(forces)}"


def guard_remarks(scores: Sequence[Score]) -> Iterator[str]:
    """Yields a sentence for each policy with a guard: the share of time in which it acted."""
    for score in scores:
        if score.guarded:
            mean, most = (100 * of(score.guarded) for of in (fmean, max))
            yield (
                f"{score.policy}: the guard acted in {mean:.2g} % of the time, in at most "
                f"{most:.2g} % of a motion"
            )


def outcome(score: Score) -> str:
    """Returns a sentence about one motion: success, effort and tracking error."""
    (effort,), (tracking,), (success,) = score.effort, score.tracking, score.success
    end = ", and the arm was lost before its end" if score.failures else ""
    return (
        f"Under {score.policy} the motion {'went well' if success else 'did not go well'}{end}: "
        f"effort {effort:.1%} of strength, tracking error {1e3 * tracking:.0f} mrad."
    )


def validation_story(found: "Validation", believed: str, suit: Suit) -> Iterator[str]:
    """Yields sentences about a believed suit: verdict with range of angles, limits, relief."""
    nrmse = found.torque.nrmse
    if nrmse is None:
        yield f"{believed}: no verdict, since the true suit has no assisted joint"
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
        yield f"{believed} does not contain the noise of its curves: {', '.join(silent)}"
    if found.relief is None:
        yield "The suit costs less than 1 % of strength here, so that relief has no meaning."
        return
    yield (
        f"relief {interval_text(found.relief)}: {interval_text(found.difference)} less the relief "
        f"with the true model, {interval_text(found.share_of_true)} of the relief with the true "
        f"model, and {interval_text(found.share_of_bound)} of that of the best known plan"
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
