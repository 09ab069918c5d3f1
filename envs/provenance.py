"""Quantities of the simulated person, suit and exoskeleton: values, units, ranges and sources."""

import csv
from collections.abc import Iterable
from dataclasses import MISSING, dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

from ..checks import pair, within

Grade = Literal["published", "transcribed", "derived", "assumed"]
"""Where a number comes from.

`published`: read in the source; `transcribed`: printed in the source, but read in somebody's copy
of it; `derived`: computed from such numbers; `assumed`: ours.
"""


@dataclass(frozen=True)
class Quantity:
    """One number of the model."""

    name: str  # name of the quantity, with dots from the general to the particular
    value: float  # number that the model uses
    unit: str  # unit of the number, "1" for a ratio
    source: str  # publication, derivation or reason
    grade: Grade  # strength of the evidence for the number


def numbers_of(*groups: str) -> tuple[Quantity, ...]:
    """Returns the numbers of `numbers.csv` whose names begin with a group, such as "control"."""
    return tuple(one for one in _numbers() if one.name.partition(".")[0] in groups)


@cache
def _numbers() -> tuple[Quantity, ...]:
    with Path(__file__).with_name("numbers.csv").open(encoding="utf-8", newline="") as file:
        rows: Any = csv.DictReader(file)
        return tuple(Quantity(**{**row, "value": float(row["value"])}) for row in rows)


def values_of(quantities: Iterable[Quantity]) -> dict[str, float]:
    """Returns the values of numbers, by name."""
    return {one.name: one.value for one in quantities}


class Setting(NamedTuple):
    """Unit, range and source of a number that is a field of a configuration."""

    unit: str  # unit of the number, "1" for a ratio; or words that follow the range
    low: float  # lowest value
    high: float  # highest value
    source: str | None  # source of the default; None if the default needs no source
    grade: Grade  # strength of the evidence for the default


def setting(
    default: Any,
    unit: str,
    low: float,
    high: float,
    *,
    source: str | None = None,
    grade: Grade = "assumed",
) -> Any:
    """Returns the field of a dataclass that holds a number, declared with unit, range and source.

    The arguments are those of `Setting` behind the default, which is `REQUIRED` for a field that
    must be given; with None the number may be left out.
    """
    return field(default=default, metadata={"setting": Setting(unit, low, high, source, grade)})


REQUIRED = MISSING


def check_settings(config: Any, prefix: str) -> None:
    """Checks numbers, and pairs of a least and a greatest number, that `setting` declares.

    The prefix begins the sentences of errors.
    """
    for one in fields(config):
        known: Setting | None = one.metadata.get("setting")
        value: Any = getattr(config, one.name)
        if known and not (value is None and one.default is None):
            unit = "" if known.unit == "1" else f" {known.unit}"
            check: Any = pair if isinstance(one.default, tuple) else within
            check(f"{prefix}{one.name}", value, known.low, known.high, unit)


def quantities_of(config: Any, name: str) -> tuple[Quantity, ...]:
    """Returns the numbers of a configuration that have a source, with a name before each."""
    declared = [(one.name, one.metadata.get("setting")) for one in fields(config)]
    return tuple(
        Quantity(f"{name}.{field}", getattr(config, field), known.unit, known.source, known.grade)
        for field, known in declared
        if known and known.source
    )
