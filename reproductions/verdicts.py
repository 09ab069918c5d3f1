"""How a printed advantage of one method over another is judged against trials of our own."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..arrays import Array

RESAMPLED = 10_000
FEWEST = 10  # trials of either method; fewer do not decide
RULE = (
    "Less is better in each row. The advantage is how much more the other method has, relative to "
    "the method of the paper. The interval is a 95 % bootstrap over the trials. Not reproduced: "
    "the interval lies below the printed advantage, or below 0 where no percentage is printed. "
    "Reproduced: else, if the interval lies above 0."
)


class Verdict(NamedTuple):
    """A claim beside our trials."""

    word: str  # "reproduced", "not reproduced" or "undecidable"
    ours: float  # median or mean of the method of the paper
    other: float  # that of the other method
    advantage: float = np.nan  # other / ours - 1
    low: float = np.nan  # ends of the interval of the advantage
    high: float = np.nan

    @property
    def cells(self) -> list[str]:
        """Our numbers, our advantage and the verdict, as cells of a table."""
        ends = f" ({100 * self.low:+.3g} to {100 * self.high:+.3g})"
        shown = "-" if np.isnan(self.low) else percent(self.advantage) + ends
        return [f"{self.ours:.6g} / {self.other:.6g}", shown, self.word]


def percent(share: float) -> str:
    """Returns a share as "+6.25 %"."""
    return f"{100 * share:+.3g} %"


def judged(
    ours: Array,
    other: Array,
    printed: float,
    *,
    seed: int,
    statistic: Callable[..., Array] = np.median,
) -> Verdict:
    """Judges the claim that the method of the paper has less of a quantity than another method.

    Args:
        ours: Quantity in each trial of the method of the paper, (trials,).
        other: The same of the other method, (trials,).
        printed: Advantage that the paper prints; 0 where the paper prints no percentage.
        seed: Seed of the bootstrap.
        statistic: What is compared: `numpy.median` or `numpy.mean`.
    """
    found = float(statistic(ours)), float(statistic(other))
    if min(ours.size, other.size) < FEWEST or not np.isfinite([*ours, *other]).all():
        return Verdict("undecidable", *found)
    rng = np.random.default_rng(seed)
    drawn = [statistic(rng.choice(one, (RESAMPLED, one.size)), axis=1) for one in (ours, other)]
    with np.errstate(divide="ignore", invalid="ignore"):  # where no trial misses an optimum
        ratios = np.nan_to_num(np.divide(drawn[1], drawn[0]), nan=1.0, posinf=np.inf)
        advantage = float(np.divide(found[1], found[0])) - 1
    low, high = map(float, np.quantile(ratios - 1, [0.025, 0.975], method="nearest"))
    word = "undecidable"
    if high < printed:
        word = "not reproduced"
    elif low > 0:
        word = "reproduced"
    return Verdict(word, *found, advantage, low, high)
