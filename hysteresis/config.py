"""`ConfigKey`: the name of a model's parameter in MJCF, and the kind of value it has there."""

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class ConfigKey:
    """One key of a model's plugin config.

    Attributes:
        name: Name of the key in MJCF.
        kind: Kind of its value: one "number", a "list" of numbers with blanks between them, or one
            "word" of `words`.
        words: Words that are allowed; a kernel gets the position of the given word among them.
        optional: Whether the key may be left out. A number is 0 then, a list is empty, and a word
            is the first of `words`.
    """

    name: str
    kind: Literal["number", "list", "word"] = "number"
    words: tuple[str, ...] = ()
    optional: bool = False
