"""Writes files in one piece, over regular files only: a crash leaves the old one or the new one.

Until it is complete, a file has a scratch name with the machine and the process in it, so that the
next writer in the same folder can remove the leftovers of a killed process.
"""

import os
import platform
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import InputError, shown

_HOST = re.sub(r"[^\w.]", "_", platform.node())[:40] or "host"
_SCRATCH = re.compile(r"\.activesuit-(?P<host>[\w.]+)-(?P<process>\d+)-\w{8}(\..*)?")


def content_of(path: str | os.PathLike[str], what: str, largest: int, fix: str = "") -> bytes:
    """Returns the bytes of a file.

    Args:
        path: Path of the file.
        what: What the file should be, as the error message calls it ("suit").
        largest: Greatest number of bytes.
        fix: What to do with a longer one, as the error message says it.
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

    Args:
        path: Path of the file to write.
        force: True to replace a file that is there, False to refuse it.
    """
    path = Path(path)
    check_target(path, force=force)
    scratch = _make_scratch(path)
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
    """Puts a finished scratch file in its place, with the permissions of the file it replaces.

    Raises:
        InputError: The path is not free, see `check_target`.
        OSError: The file system refuses.
    """
    check_target(path, force=force)
    scratch.chmod(_mode(path))
    scratch.replace(path)


def check_target(path: Path, *, force: bool = True) -> None:
    """Checks that a file may be written: nothing is there, or a regular file that may be replaced.

    Args:
        path: Path of the file to write.
        force: True if a regular file that is there may be replaced.
    """
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


def scratch_prefix() -> str:
    """Returns the prefix of the names of this process's scratch files and folders."""
    return f".activesuit-{_HOST}-{os.getpid()}-"


def remove_leftovers(folder: Path) -> None:
    """Removes the scratch files and folders in `folder` whose process on this machine is gone."""
    try:
        names = os.listdir(folder)
    except OSError:
        return  # the write that follows reports the error
    for name in names:
        found = _SCRATCH.fullmatch(name)
        if found and found["host"] == _HOST and not _runs(int(found["process"])):
            path = folder / name
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink(missing_ok=True)


def _make_scratch(path: Path) -> Path:
    remove_leftovers(path.parent)
    try:
        handle, name = tempfile.mkstemp(
            dir=path.parent, prefix=scratch_prefix(), suffix=path.suffix
        )
    except OSError as error:
        raise _unwritable(path, error) from error
    os.close(handle)
    return Path(name)


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


def _runs(process: int) -> bool:
    """Returns whether a process runs on this machine."""
    if sys.platform == "win32":
        return True  # os.kill would end the process there
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        return True
    return True
