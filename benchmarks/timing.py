"""Paired timing: two pieces of work run in turn, so that a noisy machine slows both of them."""

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

Work = Callable[[], Any]
UNITS = {"ns": 1e9, "us": 1e6, "ms": 1e3}


@dataclass(frozen=True, kw_only=True)
class Row:
    """One measurement.

    Attributes:
        what: Name of the work that was measured.
        against: Name of the work that ran in turn with it; empty if none did.
        unit: Unit of the times, for example "ns/sample".
        ours: Median time of the work.
        reference: Median time of the other work.
        cpu: Median processor time of the work in this process, of all its threads.
        reference_cpu: Median processor time of the other work in this process.
        ratio: Median of the paired ratios, reference / ours; above 1 the work is faster.
        lowest: Smallest ratio.
        highest: Largest ratio.
        target: Ratio that should be reached, if there is a target.
        limit: Time that `ours` should not exceed, if there is a limit.
    """

    what: str
    against: str = ""
    unit: str
    ours: float
    reference: float | None = None
    cpu: float | None = None
    reference_cpu: float | None = None
    ratio: float | None = None
    lowest: float | None = None
    highest: float | None = None
    target: float | None = None
    limit: float | None = None

    @property
    def met(self) -> bool:
        """Whether the target and the limit are met; true if there are none."""
        fast = self.target is None or (self.ratio is not None and self.ratio >= self.target)
        return fast and (self.limit is None or self.ours <= self.limit)

    def to_dict(self) -> dict[str, Any]:
        """Returns the numbers for JSON."""
        return {**asdict(self), "met": self.met}


def compare(
    what: str,
    ours: Work,
    against: str,
    reference: Work,
    *,
    repeats: int,
    unit: str,
    count: int = 1,
    reference_count: int | None = None,
    target: float | None = None,
) -> Row:
    """Times two pieces of work in turn; `count` is the number of units that one call does."""
    ours()
    reference()
    other = reference_count or count
    pairs = [(times(ours), times(reference)) for _ in range(repeats)]
    mine, theirs = zip(*pairs, strict=True)
    (own, own_cpu), (others, others_cpu) = zip(*mine, strict=True), zip(*theirs, strict=True)
    ratios = [(b / other) / (a / count) for a, b in zip(own, others, strict=True)]
    scale = UNITS[unit.partition("/")[0]]
    return Row(
        what=what,
        against=against,
        unit=unit,
        ours=statistics.median(own) / count * scale,
        reference=statistics.median(others) / other * scale,
        cpu=statistics.median(own_cpu) / count * scale,
        reference_cpu=statistics.median(others_cpu) / other * scale,
        ratio=statistics.median(ratios),
        lowest=min(ratios),
        highest=max(ratios),
        target=target,
    )


def measure(
    what: str, work: Work, *, repeats: int, unit: str, count: int, limit: float | None = None
) -> Row:
    """Times one piece of work against a limit of its own."""
    work()
    scale = UNITS[unit.partition("/")[0]] / count
    all_times = [times(work) for _ in range(repeats)]
    ours, cpu = (statistics.median(part) * scale for part in zip(*all_times, strict=True))
    return Row(what=what, unit=unit, ours=ours, cpu=cpu, limit=limit)


def seconds(work: Work) -> float:
    """Returns the time of one call [s]."""
    return times(work)[0]


def times(work: Work) -> tuple[float, float]:
    """Returns the time of one call, and the processor time of this process [s]."""
    start, before = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - start, time.process_time() - before
