"""Run folders: a command writes its results into a folder, each file in one piece.

A command writes into a new or an empty folder, and with `--force` into any folder. A command that
resumes an earlier run writes into the folder of that run. While a command runs, no other command
writes into its folder.
"""

import csv
import io
import json
import math
import os
import sys
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager, suppress
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, shown
from ..files import SCRATCH, check_target, replacing, write_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEW = 3  # names of files in a sentence


class RunFolder:
    """A folder of results; every file in it is written in one piece.

    Args:
        path: Path of the folder, which is made if it does not exist; also an attribute.
        force: Whether to write into a folder that is not empty, and over its files.
        resumes: Whether the command resumes an earlier run in the folder.

    Raises:
        InputError: The folder cannot be created or written, is not empty, or another process
            writes into it.
    """

    def __init__(self, path: Path, *, force: bool = False, resumes: bool = False) -> None:
        self.path = path
        if path.is_symlink():
            raise InputError(f"{str(path)!r} is a link: give the folder itself as --out")
        self._made = [one for one in (path, *path.parents) if not one.exists()]
        try:
            path.mkdir(parents=True, exist_ok=True)
            present = sorted(one.name for one in path.iterdir() if _holds_something(one))
        except (OSError, ValueError) as error:  # ValueError: a zero byte in the path
            reason = error.strerror if isinstance(error, OSError) else error
            raise InputError(
                f"cannot make the folder {str(path)!r} ({reason}): choose another --out"
            ) from error
        if not os.access(path, os.W_OK | os.X_OK):
            raise InputError(f"cannot write into {str(path)!r}: choose another --out")
        if present and not (force or resumes):
            more = f" and {len(present) - FEW} more" if len(present) > FEW else ""
            raise InputError(
                f"{str(path)!r} is not empty, it holds {', '.join(map(shown, present[:FEW]))}{more}"
                ": choose a new folder as --out, or add --force to write into it"
            )
        self._lock = _locked(path)
        _OPEN.append(self)

    @classmethod
    def of(cls, out: Path | None, command: str, *, force: bool = False) -> "RunFolder":
        """Returns the given folder, by default a new one: runs/COMMAND, runs/COMMAND-2, ..."""
        names = (command if number == 1 else f"{command}-{number}" for number in count(1))
        paths = (Path("runs", name) for name in names)
        unused = (path for path in paths if not (path.is_dir() and any(path.iterdir())))
        return cls(out or next(unused), force=force)

    def close(self) -> None:
        """Lets other processes write into the folder; removes a new folder that is still empty."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None
        with suppress(OSError):
            for made in self._made:
                made.rmdir()

    def __truediv__(self, name: str) -> Path:
        return self.path / name

    def subfolder(self, name: str) -> Path:
        """Makes a folder inside this folder, unless it exists; returns its path."""
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

    def remove(self, name: str) -> None:
        """Removes a file, if the file exists."""
        check_target(self.path / name)
        (self.path / name).unlink(missing_ok=True)

    def replacing(self, name: str) -> AbstractContextManager[Path]:
        """Yields the path of a scratch file, which becomes `name` if the block succeeds."""
        return replacing(self.path / name)

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
        write_text(self.path / name, content)

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


def _holds_something(path: Path) -> bool:
    """Returns whether a path is neither an empty folder nor a half-written file."""
    empty = path.is_dir() and not path.is_symlink() and not any(path.iterdir())
    return not empty and not path.name.startswith(SCRATCH)


_OPEN: list[RunFolder] = []


def close_folders() -> None:
    """Closes every run folder of this process, at the end of a command."""
    while _OPEN:
        _OPEN.pop().close()


def _locked(path: Path) -> int | None:
    """Locks a folder until this process ends; returns the descriptor of the folder.

    Windows has no such lock: there the user must keep two processes out of one folder.
    """
    if sys.platform == "win32":
        return None
    import fcntl

    folder = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        os.close(folder)
        raise InputError(
            f"another process writes into {str(path)!r}: wait for its end, or choose another --out"
        ) from error
    except OSError:  # a file system without locks
        pass
    return folder


def to_json(content: Any) -> str:
    """Returns `content` as strict JSON, with null in place of numbers that are not finite."""
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
