"""Writes each file in one piece, so that a crash leaves either the old file or the new file.

A file has a scratch name until it is complete; a killed process leaves that scratch file behind.
"""

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import InputError, shown

SCRATCH = ".activesuit-"  # begins the names of files that are not complete yet


def content_of(path: str | os.PathLike[str], what: str, largest: int, fix: str = "") -> bytes:
    """Returns the bytes of a file.

    Args:
        path: Path of the file.
        what: Kind of the file, for the error message ("suit").
        largest: Greatest number of bytes.
        fix: Phrase for the error message that says what to do with a longer file.
    """
    try:
        with Path(path).open("rb") as file:
            content = file.read(largest + 1)
    except (OSError, ValueError) as error:  # a path may hold a zero byte
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"cannot read the {what} {shown(str(path))}: {reason}") from error
    if len(content) > largest:
        raise InputError(
            f"cannot read the {what} {shown(str(path))}: it is longer than {largest >> 20} MiB"
            + (f"; {fix}" if fix else "")
        )
    return content


@contextmanager
def replacing(path: str | os.PathLike[str], *, force: bool = True) -> Iterator[Path]:
    """Yields the path of a scratch file, which replaces `path` if the block succeeds.

    The new file gets the permissions of the one that it replaces. A link is never followed.
    """
    path = Path(path)
    check_target(path, force=force)
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=SCRATCH, suffix=path.suffix)
    except OSError as error:
        raise _unwritable(path, error) from error
    os.close(handle)
    scratch = Path(name)
    try:
        yield scratch
        move(scratch, path, force=force)
    except OSError as error:
        raise InputError(
            f"cannot write {str(path)!r} ({error.strerror}): make room, or choose another folder"
        ) from error
    finally:
        scratch.unlink(missing_ok=True)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Writes `text` to `path` (UTF-8) in one piece: if that fails, the old file stays as it was."""
    with replacing(path) as scratch:
        scratch.write_text(text, encoding="utf-8")


def move(scratch: Path, path: Path, *, force: bool = True) -> None:
    """Puts a finished scratch file in its place, with the permissions of the file it replaces."""
    check_target(path, force=force)
    scratch.chmod(_mode(path))
    scratch.replace(path)


def check_target(path: Path, *, force: bool = True) -> None:
    """Checks that a file may be written: nothing is there, or a file that may be replaced."""
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    except OSError as error:
        raise _unwritable(path, error) from error
    if stat.S_ISLNK(mode):
        raise InputError(f"{str(path)!r} is a link: remove it, or name the file itself")
    if stat.S_ISDIR(mode):
        raise InputError(f"{str(path)!r} is a folder: give the name of a file")
    if not stat.S_ISREG(mode):
        raise InputError(f"{str(path)!r} is not a regular file: give another name")
    if not force:
        raise InputError(f"{str(path)!r} exists: give another name, or add --force to replace it")


def _unwritable(path: Path, error: OSError) -> InputError:
    return InputError(
        f"cannot write {str(path)!r} ({error.strerror}): choose a folder that exists and that you "
        "may write to"
    )


def _mode(path: Path) -> int:
    try:
        return stat.S_IMODE(path.lstat().st_mode)
    except FileNotFoundError:
        umask = os.umask(0)
        os.umask(umask)
        return 0o666 & ~umask
