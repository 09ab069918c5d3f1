"""Output of the commands: tables or JSON, a progress bar, and the files of a run folder."""

import csv
import io
import json
import math
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich import box
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from ..errors import InputError
from ..files import replacing, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Tables keep their width: on a narrow terminal lines wrap, but nothing is left out.
console = Console(highlight=False, width=max(100, shutil.get_terminal_size().columns))
Rows = tuple[list[str], list[list[str]]]  # the header of a table, and its rows of text
WIDEST = 24  # characters of a table cell that are never broken
messages = Console(stderr=True)  # progress and remarks, so that --json leaves stdout clean


class RunFolder:
    """A folder of results; every file in it is written in one piece.

    Raises:
        InputError: The folder cannot be created or written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"cannot make the folder {str(path)!r} ({error.strerror}): choose another --out"
            ) from error
        try:
            tempfile.TemporaryFile(dir=path).close()
        except OSError as error:
            raise InputError(
                f"cannot write into {str(path)!r} ({error.strerror}): choose another --out"
            ) from error

    def __truediv__(self, name: str) -> Path:
        return self.path / name

    def json(self, name: str, content: Any) -> None:
        """Writes `content` as JSON."""
        write_text(self.path / name, to_json(content) + "\n")

    def csv(self, name: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        """Writes a header and rows as CSV."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
        write_text(self.path / name, text.getvalue())

    def text(self, name: str, content: str) -> None:
        """Writes a text file."""
        write_text(self.path / name, content)

    def figure(self, name: str, figure: "Figure") -> None:
        """Writes a matplotlib figure as `name`.png and `name`.svg."""
        for suffix, options in ((".png", {"dpi": 140}), (".svg", {"metadata": {"Date": None}})):
            with replacing(self.path / (name + suffix)) as scratch:
                figure.savefig(scratch, format=suffix[1:], **options)  # pyright: ignore

    def picture(self, name: str, pixels: np.ndarray) -> None:
        """Writes an image (height, width, 3) as `name`.png."""
        from matplotlib.image import imsave

        with replacing(self.path / f"{name}.png") as scratch:
            imsave(scratch, pixels, format="png")


@contextmanager
def telling(kept: Callable[[], str]) -> Iterator[None]:
    """Makes Ctrl-C in the block report what is `kept`, unless a report has been made inside."""
    try:
        yield
    except KeyboardInterrupt as interrupt:
        if interrupt.args:
            raise
        raise KeyboardInterrupt(kept()) from None


def to_json(content: Any) -> str:
    """Returns `content` as strict JSON, where numbers that are not finite become null."""
    return json.dumps(_plain(content), indent=2, allow_nan=False)


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Path):
        return str(value)
    return value


@contextmanager
def progress(description: str, total: int) -> Iterator["Bar"]:
    """Shows a progress bar with remaining time on stderr while the block runs."""
    columns = (
        TextColumn("{task.description:<36}"),
        BarColumn(),
        TextColumn("{task.completed:>5.0f}/{task.total:.0f}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=messages, transient=not messages.is_terminal) as bars:
        yield Bar(bars, bars.add_task(description, total=total))


class Bar:
    """A progress bar on one line."""

    def __init__(self, bars: Progress, task: Any) -> None:
        self._bars, self._task = bars, task

    def advance(self, steps: float = 1) -> None:
        """Moves the bar forward by `steps`."""
        self._bars.advance(self._task, steps)

    def move_to(self, steps: float) -> None:
        """Moves the bar to `steps` of its total."""
        self._bars.update(self._task, completed=steps)


def table(title: str, header: Sequence[str], rows: Iterable[Sequence[str]], left: int = 2) -> None:
    """Prints a table; the first `left` columns are aligned left, the others right, as numbers."""
    rows = [list(row) for row in rows]
    shown = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1))
    for i, name in enumerate(header):
        longest = max(len(line) for row in [header, *rows] for line in row[i].split("\n"))
        justify = "left" if i < left else "right"
        shown.add_column(Text(name), justify=justify, min_width=min(longest, WIDEST))
    for row in rows:
        shown.add_row(*map(Text, row))
    with console.capture() as text:  # printed by print, which leaves a closed pipe to `main`
        console.print(shown)
    print(text.get(), end="")


def conclude(
    result: dict[str, Any],
    tables: Mapping[str, tuple[Sequence[str], Iterable[Sequence[str]]]],
    remarks: Iterable[str] = (),
    *,
    folder: RunFolder | None,
    json: bool,
) -> None:
    """Prints the result, as JSON or as tables and remarks; writes result.json into a folder."""
    if folder:
        folder.json("result.json", result)
    if json:
        print(to_json(result))
        return
    for title, rows in tables.items():
        table(title, *rows)
    for remark in remarks:
        print(remark)
    if folder:
        print(f"wrote {folder.path}/result.json")


def markdown_table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Returns a table as Markdown text."""
    lines = ["| " + " | ".join(name.replace("\n", " ") for name in header) + " |"]
    lines.append("|" + "---|" * len(header))
    lines += ["| " + " | ".join(cell.replace("\n", "<br>") for cell in row) + " |" for row in rows]
    return "\n".join(lines)
