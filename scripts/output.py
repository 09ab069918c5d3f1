"""Output of the commands: tables or JSON, and a progress bar."""

import shutil
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from ..tables import columns_of_words
from ..text import visible

WIDEST = 24  # characters; a shorter line of a table cell is never broken
NARROWEST = 100  # columns of a terminal; a narrower terminal wraps the lines
BETWEEN = 4  # at least the columns between two cells
QUIET = 3.0  # [s], least time between two lines about progress
messages = Console(stderr=True)  # progress and remarks, so that --json leaves stdout clean


@contextmanager
def telling(kept: Callable[[], str]) -> Iterator[None]:
    """Makes Ctrl-C in the block report `kept()`, unless an inner block has reported already."""
    try:
        yield
    except KeyboardInterrupt as interrupt:
        if interrupt.args:
            raise
        raise KeyboardInterrupt(kept()) from None


@contextmanager
def progress(description: str, total: int = 1) -> Iterator["Bar"]:
    """Shows the progress of the block on stderr: a bar on a terminal, else at most ten lines."""
    if not messages.is_terminal:
        yield Bar(_Lines(visible(description)), total)
        return
    columns = (
        TextColumn("{task.description:<36}", markup=False),
        BarColumn(),
        TextColumn("{task.completed:>5.0f}/{task.total:.0f}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=messages) as bars:
        task = bars.add_task(visible(description), total=total)
        yield Bar(lambda done, of: bars.update(task, completed=done, total=of), total)


class Bar:
    """Progress of a block; `show` gets the number of finished steps and the number of all steps."""

    def __init__(self, show: Callable[[float, float], None], total: float) -> None:
        self._show, self._done, self._total = show, 0.0, total

    def advance(self, steps: float = 1) -> None:
        """Moves the bar forward by a number of steps."""
        self.move_to(self._done + steps)

    def move_to(self, steps: float, total: float | None = None) -> None:
        """Moves the bar to a number of steps; `total` replaces the number of all steps."""
        self._done, self._total = steps, self._total if total is None else total
        self._show(self._done, self._total)


class _Lines:
    """Prints a line after each tenth of the work, for logs; no line where the work is short.

    A line does not estimate the remaining time, since steps take from seconds to minutes.
    """

    def __init__(self, description: str) -> None:
        self._description, self._tenth = description, 0
        self._begin = self._said = time.monotonic()

    def __call__(self, done: float, total: float) -> None:
        now, tenth = time.monotonic(), int(10 * done / max(total, 1))
        if tenth > self._tenth and now - self._said >= QUIET:
            self._tenth, self._said = tenth, now
            percent, taken = 100 * done / total, now - self._begin
            said = f"{self._description}: {percent:.0f} % after {taken:.0f} s"
            print(said, file=sys.stderr, flush=True)


def table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Prints a table; columns of words are aligned left, those of numbers right.

    Nothing is left out: a terminal breaks long cells, and elsewhere no cell is broken.
    """
    header, rows = _visible(header), [_visible(row) for row in rows]
    shown = Table(box=box.SIMPLE_HEAD, padding=(0, 1))
    longest = [
        max(cell_len(line) for row in [header, *rows] for line in row[i].split("\n"))
        for i in range(len(header))
    ]
    least = [min(length, WIDEST) for length in longest]
    for name, words, width in zip(header, columns_of_words(header, rows), least, strict=True):
        justify = "left" if words else "right"
        shown.add_column(Text(name), justify=justify, min_width=width, overflow="fold")
    for row in rows:
        shown.add_row(*map(Text, row))
    if sys.stdout.isatty():
        terminal = max(NARROWEST, shutil.get_terminal_size().columns)
        width = max(terminal, sum(length + BETWEEN for length in least))
    else:
        width = sum(length + BETWEEN for length in longest)
    console = Console(highlight=False, width=width)
    with console.capture() as text:  # printed by print, which leaves a closed pipe to `main`
        console.print(Text(visible(title), style="italic"), soft_wrap=True)  # a title of one line
        console.print(shown)
    print(text.get(), end="")


def _visible(cells: Iterable[str]) -> list[str]:
    return [visible(cell) for cell in cells]
