"""The next record to measure: a motion that distinguishes models that first-order curves do not.

Models that agree on first-order curves differ where a reversal lies inside others. One record that
reverses many times, each time nearer to the middle of the range, shows all depths at once. Every
branch has another rate, so that the record also shows whether the torque depends on the rate.
"""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arrays import Array
from ..checks import number
from ..errors import InputError
from ..table_files import RADIANS_AT_MOST

BRANCHES = 9  # number of branches on the way inwards, each a ninth of the range shorter
MIN_RATE, MAX_RATE = 0.02, 0.5  # assumed rates [rad/s]: slow, and the fastest of the simulated rig
SAMPLE_RATE = 25.0  # assumed rate [Hz], that of the simulated rig
SHORTEST = 1.0  # assumed time of a branch [s], in which a motor speeds up and slows down
LONGEST = 3600.0  # longest record of the simulated rig [s]
MOST = 1_000_000  # largest number of samples
GOLDEN = (math.sqrt(5) - 1) / 2  # golden ratio; its multiples modulo 1 spread evenly, however many


class Design(NamedTuple):
    """A record to measure.

    Attributes:
        time: Time of each sample [s], shape (n,), from 0.
        angle: Angle of the joint [rad], shape (n,).
        points: First angle, reversals and last angle [rad].
        rates: Rate of each branch between them [rad/s].
    """

    time: Array
    angle: Array
    points: tuple[float, ...]
    rates: tuple[float, ...]

    @property
    def duration(self) -> float:
        """Time from the first sample to the last one [s]."""
        return float(self.time[-1])


def nested_motion(
    start: float,
    end: float,
    *,
    min_rate: float = MIN_RATE,
    max_rate: float = MAX_RATE,
    sample_rate: float = SAMPLE_RATE,
) -> Design:
    """Returns a record that reverses at all depths, each branch at another rate.

    It begins at `start`, and its reversals approach the middle of the range from both ends, by a
    ninth of the range each; then it goes straight back to where it began. Rates are spread evenly
    in their logarithm, in an order that depends neither on depth nor on direction; a branch takes a
    second at least, so that a motor can follow.

    Added to five first-order curves, it lowered the error on random motions in 42 of 60 fits to
    truths outside the models' classes; four more first-order curves lowered it in 29. Its shape was
    chosen on other truths: there, reversals on the way out as well doubled its length and did not
    improve the fits (77 instead of 82 of 96 lower).

    Args:
        start: Angle at which it begins and ends [rad], one end of the range.
        end: The other end of the range [rad].
        min_rate: Rate of the slowest branch [rad/s].
        max_rate: Largest rate of a branch [rad/s].
        sample_rate: Least number of samples per second [Hz].
    """
    for name, angle in (("start", start), ("end", end)):
        if abs(number(name, angle, "rad")) > RADIANS_AT_MOST:
            raise InputError(f"{name} is {angle:g} rad, more than a full turn: give radians")
    if start == end:
        raise InputError(f"the range is from {start:g} to {end:g} rad: give two angles that differ")
    for name, value, unit in (
        ("min_rate", min_rate, "rad/s"),
        ("max_rate", max_rate, "rad/s"),
        ("sample_rate", sample_rate, "Hz"),
    ):
        if number(name, value, unit) <= 0:
            raise InputError(f"{name} is {value:g} {unit}: give a number above 0")
    if min_rate > max_rate:
        raise InputError(
            f"min_rate is {min_rate:g} and max_rate {max_rate:g} rad/s: give the smaller one first"
        )
    inwards = [point for i in range((BRANCHES + 1) // 2) for point in (i, BRANCHES - i)]
    share = np.array([*inwards, 0]) / BRANCHES
    points = (1 - share) * start + share * end
    ways = np.abs(np.diff(points))
    rates = np.geomspace(min_rate, max_rate, ways.size)[_spread(ways.size)]
    rates = np.maximum(np.minimum(rates, ways / SHORTEST), min_rate)
    took = ways / rates
    if took.sum() > LONGEST:
        raise InputError(
            f"the record would take {took.sum():.0f} s: give a larger min_rate than {min_rate:g} "
            f"rad/s, so that it takes {LONGEST:.0f} s at most"
        )
    if took.sum() * sample_rate > MOST:
        raise InputError(
            f"the record would have {took.sum() * sample_rate:.3g} samples: give a smaller "
            f"sample_rate than {sample_rate:g} Hz, so that they are {MOST:,} at most"
        )
    turns = np.concatenate([[0.0], np.cumsum(took)])
    pieces = [
        np.linspace(now, then, max(math.ceil((then - now) * sample_rate), 1) + 1)[1:]
        for now, then in pairwise(turns)
    ]
    time = np.concatenate([[0.0], *pieces])
    return Design(
        time=time,
        angle=np.interp(time, turns, points),
        points=tuple(points.tolist()),
        rates=tuple(rates.tolist()),
    )


def _spread(count: int) -> list[int]:
    """Returns the numbers 0 to count - 1 in an order without a trend, the largest one first."""
    return np.argsort(np.argsort([1 - i * GOLDEN % 1 for i in range(count)])).tolist()
