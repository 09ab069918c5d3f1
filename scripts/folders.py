"""Run folders: a command writes into a new or an empty folder, or into any one with `--force`.

Every file is written beside its place and renamed, so that a killed command leaves whole files.
While a command runs, no other one writes into its folder.
"""

import csv
import io
import json
import math
import os
import sys
import tempfile
import weakref
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..files import check_target, replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEW = 3  # names of files in a sentence


class RunFolder:
    """A folder of results; every file in it is written in one piece.

    Args:
        path: Path of the folder, which is made if it does not exist.
        force: True to write into a folder that holds files, and over them.
        resumes: True if the folder holds what the command has begun and goes on with.

    Attributes:
        path: Path of the folder.

    Raises:
        InputError: The folder cannot be created or written, holds something, or another process
            writes into it.
    """

    def __init__(self, path: Path, *, force: bool = False, resumes: bool = False) -> None:
        self.path = path
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
            names = sorted(name for name in os.listdir(path) if not name.startswith("."))
            tempfile.TemporaryFile(dir=path).close()
            self._lock = _Lock(path)
        except OSError as error:
            raise InputError(
                f"cannot write into {str(path)!r} ({error.strerror}): choose another --out"
            ) from error
        if names and not (force or resumes):
            shown = ", ".join(names[:FEW]) + (", ..." if len(names) > FEW else "")
            raise InputError(
                f"{str(path)!r} holds files ({shown}): choose another --out, or add --force to "
                "write there"
            )
        _OPEN.add(self)

    def close(self) -> None:
        """Lets other processes write into the folder; removes it if it is new and still empty."""
        self._lock.end()
        with suppress(OSError):
            for made in self._made:
                made.rmdir()

    def __truediv__(self, name: str) -> Path:
        return self.path / name

    def claim(self, name: str) -> Path:
        """Returns the path of a file that the command is about to write.

        Raises:
            InputError: A link or a folder is there.
        """
        check_target(self.path / name)
        return self.path / name

    def subfolder(self, name: str) -> Path:
        """Makes a folder in this one, unless it is there; returns its path.

        Raises:
            InputError: A link or a file is there, or the folder cannot be made.
        """
        path = self.path / name
        if path.is_symlink():
            raise InputError(f"{str(path)!r} is a link: remove it, or choose another --out")
        try:
            path.mkdir(exist_ok=True)
        except OSError as error:
            raise InputError(
                f"cannot make the folder {str(path)!r} ({error.strerror}): choose another --out"
            ) from error
        return path

    @contextmanager
    def replacing(self, name: str) -> Iterator[Path]:
        """Yields the path of a scratch file, which becomes `name` if the block succeeds."""
        with replacing(self.path / name) as scratch:
            yield scratch

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


class _Lock:
    """The lock of a folder for this process, where the system has such."""

    def __init__(self, path: Path) -> None:
        self.end = lambda: None
        if sys.platform == "win32":
            return
        import fcntl

        descriptor = os.open(path, os.O_RDONLY)
        self.end = weakref.finalize(self, os.close, descriptor)
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.end()
            raise InputError(
                f"another command writes into {str(path)!r}: wait until it ends, or choose "
                "another --out"
            ) from None
        except OSError:  # a file system without locks
            return


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
