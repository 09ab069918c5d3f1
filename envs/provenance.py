"""Quantities of the simulated person, suit and exoskeleton, with their sources."""

from dataclasses import dataclass
from typing import Literal

Grade = Literal["published", "transcribed", "derived", "assumed"]
"""Where a number comes from.

`published`: read in the source; `transcribed`: printed in the source, but read in somebody's copy
of it; `derived`: computed from such numbers; `assumed`: ours.
"""


@dataclass(frozen=True)
class Quantity:
    """One number of the model.

    Attributes:
        name: Name of the quantity, with dots from the general to the particular.
        value: Number that the model uses.
        unit: Unit of the number, "1" for a ratio.
        source: Publication, derivation or reason.
        grade: Strength of the evidence for the number.
    """

    name: str
    value: float
    unit: str
    source: str
    grade: Grade
