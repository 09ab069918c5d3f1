"""Run folders: which command a folder of results belongs to, and which files it may replace.

A command writes into a new or an empty folder, or into one that it made before: the file
`.activesuit` in it names the command, and the files that this has written, which alone it replaces.
Anything else needs `--force`. While a command runs, no other one writes into its folder.
"""

import csv
import io
import json
import math
import os
import shutil
import stat
import sys
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..files import check_target, move, remove_leftovers, replacing, scratch_prefix

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RECORD = ".activesuit"
FIRST_LINE = "activesuit "  # and the name of the command; each other line names a file it wrote
LONGEST = 1 << 20  # bytes of a record; a longer one is not ours
FEW = 3  # names of foreign files in a sentence


class RunFolder:
    """A folder of results; every file in it is written in one piece.

    Args:
        path: Path of the folder, which is made if it does not exist.
        command: Name of the command that writes; "" for a folder inside another run folder, of
            which no record is kept.
        force: True to write into a folder of another command, and over files that are there.

    Attributes:
        path: Path of the folder.
        own: Whether this command has written into it before.

    Raises:
        InputError: The folder cannot be created or written, holds something else, or another
            process writes into it.
    """

    def __init__(self, path: Path, command: str = "", *, force: bool = False) -> None:
        self.path = path
        self._force = force or not command
        self._record = None
        if path.is_symlink():
            raise InputError(f"{str(path)!r} is a link: give the folder itself as --out")
        self._made = [one for one in (path, *path.parents) if not one.exists()]
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"cannot make the folder {str(path)!r} ({error.strerror}): choose another --out"
            ) from error
        try:
            if command:
                self._record = _Record(path, command, force)
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


class _Record:
    """The file `.activesuit` of a run folder, locked by the process that writes into the folder.

    Names are appended before their files are written, so that a killed run leaves none unlisted.
    """

    def __init__(self, folder: Path, command: str, force: bool) -> None:
        self._path = path = folder / RECORD
        self._first_line = FIRST_LINE + command
        if not force and not path.exists():
            _check_empty(folder, command)
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_NOFOLLOW", 0)
        self._file = os.open(path, flags, 0o666)
        self._end = weakref.finalize(self, os.close, self._file)
        if not stat.S_ISREG(os.fstat(self._file).st_mode):
            raise InputError(f"{str(path)!r} is not a regular file: choose another --out")
        if not _lock(self._file):
            raise InputError(
                f"another command writes into {str(folder)!r}: wait until it ends, or choose "
                "another --out"
            )
        lines = self._read()
        self.own = self._begun = lines[:1] == [self._first_line]
        self.names = set(lines[1:]) if self.own else set[str]()
        if not self.own and not force:
            if lines:
                raise _foreign(folder, command, lines[0])
            _check_empty(folder, command)

    def close(self) -> bool:
        """Ends the lock; removes a record without content, and returns whether it did."""
        empty = self._end.alive and not os.fstat(self._file).st_size
        if empty:
            self._path.unlink(missing_ok=True)
        self._end()
        return empty

    def add(self, name: str) -> None:
        """Puts the name of a file on record."""
        if not self._begun:
            os.ftruncate(self._file, 0)
            self._append(self._first_line)
            self._begun = True
        if name not in self.names:
            self.names.add(name)
            self._append(name)

    def _read(self) -> list[str]:
        # Through the locked file: to open and close it once more would end the lock.
        os.lseek(self._file, 0, os.SEEK_SET)
        return os.read(self._file, LONGEST).decode(errors="replace").splitlines()

    def _append(self, line: str) -> None:
        os.write(self._file, f"{line}\n".encode())


def _check_empty(folder: Path, command: str) -> None:
    names = sorted(name for name in os.listdir(folder) if not name.startswith("."))
    if names:
        shown = ", ".join(names[:FEW]) + (", ..." if len(names) > FEW else "")
        raise InputError(
            f"{str(folder)!r} holds files that are not of a run of {command} ({shown}): choose "
            "another --out, or add --force to write there"
        )


def _foreign(folder: Path, command: str, line: str) -> InputError:
    other = line.removeprefix(FIRST_LINE) if line.startswith(FIRST_LINE) else "another program"
    return InputError(
        f"{str(folder)!r} holds a run of {other}, not of {command}: choose another --out, or add "
        "--force to write there"
    )


if sys.platform == "win32":
    import msvcrt

    def _lock(file: int) -> bool:
        """Locks a file for this process; returns False if another one has it."""
        place = os.lseek(file, 0, os.SEEK_CUR)
        os.lseek(file, 1 << 30, os.SEEK_SET)  # a byte that is never read
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        finally:
            os.lseek(file, place, os.SEEK_SET)
        return True
else:
    import fcntl

    def _lock(file: int) -> bool:
        """Locks a file for this process; returns False if another one has it."""
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            return False
        except OSError:
            return True  # a file system without locks
        return True


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
