"""Sentences about why motions did not go well: which limit was exceeded, by how much and when."""

from collections.abc import Iterator, Sequence

import numpy as np

from .core import REFERENCES
from .reasons import Frequent, most_frequent
from .scores import Score

LEAST = 0.01  # share of time at the peak torque that is worth a word
# Words for a limit, the factor of its numbers, and their unit.
_WORDS = {
    "worst_joint": ("{part}", 1e3, "mrad"),
    "effort": ("effort", 100, "%"),
    "hand_error": ("hand", 1e3, "mm"),
    "tilt": ("tilt of the hand", 1e3, "mrad"),
    "slowness": ("hand too slow by", 100, "%"),
    "cuff_force": ("force of the {part} cuff", 100, "% of what a person bears"),
    "heat": ("load of the {part} motor", 100, "% of continuous"),
}
# Limits that an arm without motors can exceed, in a sentence.
_UNASSISTED = {
    "worst_joint": "tracking",
    "effort": "effort",
    "hand_error": "the hand's place",
    "tilt": "the hand's tilt",
    "slowness": "the hand's speed",
    "lost": "the arm's range",
}


def why_remarks(scores: Sequence[Score]) -> Iterator[str]:
    """Yields a sentence for each policy some of whose motions failed, frequent reasons first.

    Another one follows where the suited arm without assistance exceeds a limit in none of the
    motions in which the policy does, if its score is among them.
    """
    suited = next((one for one in scores if one.policy == REFERENCES[1]), None)
    for one in scores:
        failed = one.success.count(False)
        if failed:
            of = f" in {failed} of {len(one.success)} motions" if len(one.success) > 1 else ""
            parts = [exceeded(why) + _count(why, failed) for why in most_frequent(one.why)]
            yield f"{one.policy} failed{of}: {'; '.join([*parts, *_hot(one)])}"
            kept = _kept_unassisted(one, suited) if suited else []
            if kept and one.policy not in REFERENCES:
                limits = "this limit" if len(kept) == 1 else "these limits"
                yield (
                    f"{one.policy}: without assistance the same motions stay within {limits}: "
                    f"{', '.join(kept)}"
                )


def _kept_unassisted(score: Score, suited: Score) -> list[str]:
    """Returns words for the limits that the suited arm keeps in all motions that exceed them."""
    exceeded: dict[str, list[bool]] = {}
    for mine, theirs in zip(score.why, suited.why, strict=True):
        for reason in mine:
            also = any(one.name == reason.name for one in theirs)
            exceeded.setdefault(reason.name, []).append(also)
    return [words for name, words in _UNASSISTED.items() if not any(exceeded.get(name, [True]))]


def _count(why: Frequent, failed: int) -> str:
    return f" ({motions_text(why.motions)})" if why.motions < failed else ""


def motions_text(count: int) -> str:
    """Returns a number of motions in words."""
    return "1 motion" if count == 1 else f"{count} motions"


def exceeded(why: Frequent) -> str:
    """Returns by how much a limit was exceeded, and when: the medians of these motions."""
    part = (why.part or "").removesuffix("_flexion").replace("_", " ")
    if why.name == "lost":
        return f"arm lost at {why.time_s:.1f} s ({part})"
    words, factor, unit = _WORDS[why.name]
    size = f"{_number(factor * why.value)} {unit} of {_number(factor * why.limit)}"
    return f"{words.format(part=part)} {size} from {why.time_s:.1f} s{_swing(why)}"


def _swing(why: Frequent) -> str:
    """Returns period and amplitude of an oscillation; nothing where there is none."""
    if why.oscillation is None:
        return ""
    _, factor, unit = _WORDS[why.name]
    period, amplitude = why.oscillation.period_s, _number(factor * why.oscillation.amplitude)
    return f", oscillates with a period of {period:.2g} s, amplitude {amplitude} {unit}"


def _number(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _hot(score: Score) -> Iterator[str]:
    """Yields motors that were hot, or gave their peak torque, in motions that failed."""
    bad = ~np.array(score.success)
    for joint, times in score.hot_from.items():
        hot = np.array(times)[bad]
        name = joint.removesuffix("_flexion")
        if np.isfinite(hot).any():
            yield f"{name} motor hot from {np.median(hot[np.isfinite(hot)]):.1f} s"
        full = np.array(score.saturated[joint])[bad]
        if full.max() >= LEAST:
            yield f"{name} motor at its peak in {100 * np.median(full):.0f} % of the time"
