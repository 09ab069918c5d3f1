"""Tables of text: a header and rows."""

import re
from collections.abc import Iterable, Sequence

from .text import visible

Rows = tuple[list[str], list[list[str]]]  # the header of a table, and its rows of text
_NUMBER = re.compile(r"[-+−]?\d[\d,]*\.?\d*(e[-+]?\d+)?(?![\w-])")


def columns_of_words(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[bool]:
    """Returns for each column whether the cells are words, aligned left, or begin with numbers."""
    columns = [
        [row[i] for row in rows if row[i].strip() not in ("", "-")] for i in range(len(header))
    ]
    return [not (cells and all(map(_NUMBER.match, cells))) for cells in columns]


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Returns a table as Markdown text."""
    cells = [[visible(cell) for cell in row] for row in (header, *rows)]
    lines = ["| " + " | ".join(name.replace("\n", " ") for name in cells[0]) + " |"]
    lines.append("|" + "---|" * len(header))
    lines += [
        "| " + " | ".join(one.replace("\n", "<br>") for one in row) + " |" for row in cells[1:]
    ]
    return "\n".join(lines)
