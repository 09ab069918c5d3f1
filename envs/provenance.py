"""Where the numbers of the simulated person, suit and exoskeleton come from."""

from dataclasses import dataclass
from typing import Literal

Grade = Literal["published", "derived", "assumed"]
"""`published`: read in the source; `derived`: computed from published values; `assumed`: ours."""


@dataclass(frozen=True)
class Quantity:
    """One number of the model.

    Attributes:
        name: what it is, dotted from the general to the particular.
        value: the number the model uses.
        unit: its unit, "1" for a ratio.
        source: publication, derivation or reason.
        grade: how well the number is supported.
    """

    name: str
    value: float
    unit: str
    source: str
    grade: Grade
