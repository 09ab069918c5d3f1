"""Safe text for a terminal: names from files cannot move the cursor or change colors."""

import sys
import unicodedata
from typing import TextIO

# Control and format characters, such as those that turn the direction of writing; halves of
# characters, which bytes of a file name become; separators of lines and paragraphs.
_HIDDEN = {"Cc", "Cf", "Cs", "Zl", "Zp"}
MARKUP = "<>|[]`&\\"


def visible(text: str) -> str:
    """Returns `text` with control characters, except for line breaks, as Python escapes them."""
    return "".join(
        char if char == "\n" or unicodedata.category(char) not in _HIDDEN else _escape(char)
        for char in text
    )


def without_markup(text: str) -> str:
    """Returns a text that Markdown and HTML show unchanged, except for line breaks."""
    return "".join(f"&#{ord(char)};" if char in MARKUP else char for char in text)


def say(text: str, file: TextIO | None = None) -> None:
    """Prints a line of text whose control characters are made visible; to stdout by default."""
    print(visible(text), file=file or sys.stdout)


def _escape(char: str) -> str:
    return (
        char.encode("ascii", "backslashreplace").decode() if ord(char) > 127 else repr(char)[1:-1]
    )
