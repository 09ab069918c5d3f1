"""What a model's parameters are called in MJCF, and what is written there."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class ConfigKey:
    """One key of a model's plugin config.

    Attributes:
        name: Name of the key in MJCF.
        kind: What its value is: one "number", a "list" of numbers with blanks between them, or one
            "word" of `words`.
        words: Words that are allowed; a kernel sees the position of the one that is given.
        optional: Whether the key may be left out. A number is 0 then, a list is empty, and a word
            is the first of `words`.
    """

    name: str
    kind: Literal["number", "list", "word"] = "number"
    words: tuple[str, ...] = ()
    optional: bool = False
