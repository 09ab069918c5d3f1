"""Tables of text: a header and rows."""

from collections.abc import Iterable, Sequence

from .text import visible

Rows = tuple[list[str], list[list[str]]]  # the header of a table, and its rows of text


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Returns a table as Markdown text."""
    cells = [[visible(cell) for cell in row] for row in (header, *rows)]
    lines = ["| " + " | ".join(name.replace("\n", " ") for name in cells[0]) + " |"]
    lines.append("|" + "---|" * len(header))
    lines += [
        "| " + " | ".join(one.replace("\n", "<br>") for one in row) + " |" for row in cells[1:]
    ]
    return "\n".join(lines)
