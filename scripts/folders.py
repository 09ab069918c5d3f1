"""Run folders: which command a folder of results belongs to, and which files it may replace.

A command writes into a new or an empty folder, or into one that it made before: the file
`.activesuit` in it names the command, and the files that this has written, which alone it replaces.
Anything else needs `--force`. While a command runs, no other one writes into its folder.
"""

import csv
import io
import json
import math
import shutil
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..files import check_target, move, remove_leftovers, replacing, scratch_prefix
from .record import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class RunFolder:
    """A folder of results; every file in it is written in one piece.

    Args:
        path: Path of the folder, which is made if it does not exist.
        command: Name of the command that writes; "" for a folder inside another run folder, of
            which no record is kept.
        force: True to write into a folder of another command, and over files that are there.

    Attributes:
        path: Path of the folder.
        command: Name of the command that writes.
        own: Whether this command has written into it before.

    Raises:
        InputError: The folder cannot be created or written, holds something else, or another
            process writes into it.
    """

    def __init__(self, path: Path, command: str = "", *, force: bool = False) -> None:
        self.path, self.command = path, command
        self._force = force or not command
        self._record = None
        if path.is_symlink():
            raise InputError(f"{str(path)!r} is a link: give the folder itself as --out")
        self._made = [one for one in (path, *path.parents) if not one.exists()]
        try:
            path.mkdir(parents=True, exist_ok=True)
        except (OSError, ValueError) as error:  # ValueError: a zero byte in the path
            reason = error.strerror if isinstance(error, OSError) else error
            raise InputError(
                f"cannot make the folder {str(path)!r} ({reason}): choose another --out"
            ) from error
        try:
            if command:
                self._record = Record(path, command, force)
            tempfile.TemporaryFile(dir=path).close()
        except OSError as error:
            raise InputError(
                f"cannot write into {str(path)!r} ({error.strerror}): choose another --out"
            ) from error
        self.own = self._record is not None and self._record.own
        remove_leftovers(path)
        _OPEN.add(self)

    def close(self) -> None:
        """Lets other processes write into the folder; removes it if it is new and still empty."""
        if self._record is not None and self._record.close():
            with suppress(OSError):
                for made in self._made:
                    made.rmdir()

    def __truediv__(self, name: str) -> Path:
        return self.path / name

    def claim(self, name: str) -> Path:
        """Returns the path of a file that the command is about to write, and puts it on record.

        Raises:
            InputError: A link or a folder is there, or a file that the command has not written.
        """
        path = self.path / name
        ours = self._force or (self._record is not None and name in self._record.names)
        check_target(path, force=True)
        if not ours and path.exists():
            raise InputError(
                f"{str(path)!r} was not written by this command: choose another --out, or add "
                "--force to replace it"
            )
        self._note(name)
        return path

    def subfolder(self, name: str) -> Path:
        """Makes a folder in this one, unless it is there; returns its path.

        Raises:
            InputError: A link or a file is there, or the folder cannot be made.
        """
        path = self.path / name
        if path.is_symlink():
            raise InputError(f"{str(path)!r} is a link: remove it, or choose another --out")
        self._note(name)
        try:
            path.mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(
                f"cannot make the folder {str(path)!r} ({error.strerror}): choose another --out"
            ) from error
        remove_leftovers(path)
        return path

    @contextmanager
    def replacing(self, name: str) -> Iterator[Path]:
        """Yields the path of a scratch file, which becomes `name` if the block succeeds."""
        with replacing(self.claim(name)) as scratch:
            yield scratch

    @contextmanager
    def together(self, kept: str | None = None) -> Iterator["RunFolder"]:
        """Yields a folder whose files move into this one at the end of the block, if it succeeds.

        So the results of an earlier run stay together until all of the new ones are there.

        Args:
            kept: Name of a new folder in this one that keeps the files when Ctrl-C ends the block;
                by default they are removed.
        """
        scratch = Path(tempfile.mkdtemp(dir=self.path, prefix=scratch_prefix()))
        try:
            yield RunFolder(scratch)
            finished = sorted(scratch.iterdir())
            for path, target in [(path, self.claim(path.name)) for path in finished]:
                move(path, target)
        except KeyboardInterrupt:
            if kept:
                for path in sorted(scratch.iterdir()):
                    move(path, self.subfolder(kept) / path.name)
            raise
        finally:
            shutil.rmtree(scratch, ignore_errors=True)

    def json(self, name: str, content: Any) -> None:
        """Writes `content` as JSON."""
        self.text(name, to_json(content) + "\n")

    def csv(self, name: str, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
        """Writes a header and rows as CSV."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
        self.text(name, text.getvalue())

    def text(self, name: str, content: str) -> None:
        """Writes a text file."""
        with self.replacing(name) as scratch:
            scratch.write_text(content, encoding="utf-8")

    def figure(self, name: str, figure: "Figure") -> None:
        """Writes a matplotlib figure as `name`.png and `name`.svg."""
        for suffix, options in ((".png", {"dpi": 140}), (".svg", {"metadata": {"Date": None}})):
            with self.replacing(name + suffix) as scratch:
                figure.savefig(scratch, format=suffix[1:], **options)  # pyright: ignore

    def picture(self, name: str, pixels: np.ndarray) -> None:
        """Writes an image (height, width, 3) as `name`.png."""
        from matplotlib.image import imsave

        with self.replacing(f"{name}.png") as scratch:
            imsave(scratch, pixels, format="png")

    def _note(self, name: str) -> None:
        if self._record is not None:
            self._record.add(name)


_OPEN: weakref.WeakSet[RunFolder] = weakref.WeakSet()


def close_folders() -> None:
    """Closes every run folder of this process, at the end of a command."""
    for folder in list(_OPEN):
        folder.close()


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
