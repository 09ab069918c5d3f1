"""Remarks on a fit: what to know before trusting it, and which option would act on it."""

from dataclasses import dataclass
from typing import Literal

Code = Literal[
    "coverage",
    "disorder",
    "unit",
    "clock",
    "coarse",
    "encoder",
    "copy",
    "work",
    "sign",
    "exchanged",
    "clipped",
    "turn",
    "label",
    "range",
    "certificate",
    "form",
    "limit",
    "misfit",
    "nothing",
    "outliers",
    "tare",
    "open",
    "rate",
    "lag",
    "play",
    "gap",
    "drift",
    "offset",
    "gain",
    "softening",
    "search",
    "wandering",
    "memoryless",
    "start",
    "thinned",
]
"""What a remark is about.

The curves: `coverage` (they do not cover the intended motion), `disorder` (noisy or not in order),
`unit`, `clock`, `coarse`, `encoder`, `copy`, `outliers`, `work` (the loops give energy back),
`sign` (the torque falls where the angle rises), `exchanged` (the columns of angle and torque),
`clipped`, `turn` (it is missing), `label` (one for several curves), `thinned` (a part of the
samples is used).
The model: `range` (safe between some angles), `form` (others fit as well), `certificate` and
`limit` (the fit ended at a limit),
`misfit`, `nothing` (nothing is explained), `search` (ended early), `wandering` (noise or misfit),
`memoryless` (no memory is needed), `start` (where curves and model begin).
Faults of the measurement, or terms that were not found: `tare`, `open` (the offset that was asked
for is not determined), `rate`, `lag`, `play`, `gap`, `drift`, `offset` and `gain` of one curve,
`softening`.
"""

_PARTS = {
    **dict.fromkeys(("tare", "rate", "play", "softening"), "corrections=Corrections({})"),
    "objective": "method=Search(..., {})",
}


@dataclass(frozen=True)
class Remark:
    """A reason to doubt a fit.

    Attributes:
        code: What it is about.
        sentence: The remark in words, with what to do about the measurement.
        option: Option of `identify`, and its value, that would act on it; None if there is none.
            The command line writes it as `--tare fit`.
    """

    code: Code
    sentence: str
    option: tuple[str, str] | None = None

    def __str__(self) -> str:
        if self.option is None:
            return self.sentence
        if self.option == ("method", "auto"):
            return f"{self.sentence} (select(curves))"
        name, value = self.option
        return f"{self.sentence} ({_PARTS.get(name, '{}').format(f'{name}={value!r}')})"
