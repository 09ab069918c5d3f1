"""What the programs share: tables that are printed, kept and put on a page, and figures."""

import csv
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import tyro
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..errors import InputError
from ..files import write_text


class Results:
    """Prints what a program finds, and keeps it in the folder `out`."""

    def __init__(self, out: Path) -> None:
        out.mkdir(parents=True, exist_ok=True)
        self.out = out
        self._markdown: list[str] = []
        self._page: list[str] = []

    def say(self, *sentences: str) -> None:
        """Prints sentences, a line each."""
        print("\n".join(sentences))
        self._markdown.append("\n".join(f"- {sentence}" for sentence in sentences))

    def table(
        self,
        title: str,
        note: str,
        header: str,
        rows: Iterable[Sequence[str]],
        *,
        on_page: bool = False,
    ) -> None:
        """Prints a table, with "|" between its names, below a note that says how to read it.

        With `on_page` the page of the documentation gets the table, without the note.
        """
        cells = [header.split(" | "), *rows]
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        lines = ["  ".join(map(str.ljust, row, widths)).rstrip() for row in cells]
        print(f"\n{title}\n{note}\n", *lines, "", sep="\n")
        lines = ["| " + " | ".join(row) + " |" for row in cells]
        lines.insert(1, "|" + "---|" * len(cells[0]))
        table = "\n".join(lines)
        self._markdown += [f"### {title}", f"**How to read this.** {note}", table]
        if on_page:
            self._page += [f"### {title}", table]

    def csv(self, name: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        """Writes numbers with all their digits."""
        with (self.out / name).open("w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows([header, *rows])

    def figures(self, drawn: dict[str, Figure | str]) -> None:
        """Saves figures, and prints which file has which, or what one without data shows."""
        lines = []
        for name, figure in drawn.items():
            shown, of = figure, " of the paper" if name.startswith("Fig.") else ""
            if isinstance(figure, Figure):
                shown = name.lower().replace("fig.", "figure").replace(" ", "_") + ".png"
                figure.savefig(self.out / shown, dpi=150)
                shown = f"{self.out.name}/{shown}"
            lines.append(f"{name}{of}: {shown}")
        self.say(*lines)

    def finish(self, page: Path | None) -> None:
        """Writes tables.md, and puts tables between the marks of this program on a page."""
        write_text(self.out / "tables.md", "\n\n".join(self._markdown) + "\n")
        print(f"figures, tables.md and CSV files are in {self.out}")
        if page is not None:
            begin, end = (f"<!-- {which}: {self.out.name} -->" for which in ("made by", "end"))
            before, found, rest = page.read_text(encoding="utf-8").partition(begin)
            if not found or end not in rest:
                raise InputError(f"{page} has not both marks: put {begin!r} and {end!r}")
            text = "\n\n".join(self._page)
            write_text(page, f"{before}{begin}\n\n{text}\n\n{end}{rest.partition(end)[2]}")


def panels(titles: Sequence[str], ylabel: str, rows: int = 1, **options) -> tuple[Figure, list]:
    """Returns a figure with a panel for each title, and the panels."""
    figure = Figure(figsize=(9, 3.6 * rows), layout="constrained")
    grid = figure.subplots(rows, len(titles) // rows, squeeze=False, **options)
    axes: list[Axes] = list(grid.flat)
    for ax, title in zip(axes, titles, strict=True):
        ax.set_title(title, loc="left", fontsize=10)
        ax.grid(alpha=0.25)
    for ax in grid[:, 0]:
        ax.set_ylabel(ylabel)
    return figure, axes


def run(main: Callable[..., None]) -> None:
    """Runs a program with the options of the command line; a mistake ends with one sentence."""
    try:
        tyro.cli(main)
    except InputError as error:
        sys.exit(f"error: {error}")
