"""Writing files in one piece: a crash or a full disk leaves the old file, never half a new one."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import InputError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yields the path of a temporary file, which replaces `path` if the block succeeds.

    Raises:
        InputError: The folder does not exist or cannot be written, or the disk is full.
    """
    path = Path(path)
    try:
        handle, name = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix
        )
    except OSError as error:
        raise InputError(
            f"cannot write {str(path)!r} ({error.strerror}): choose a folder that exists and that "
            "you may write to"
        ) from error
    os.close(handle)
    scratch = Path(name)
    try:
        yield scratch
        umask = os.umask(0)
        os.umask(umask)
        scratch.chmod(0o666 & ~umask)
        scratch.replace(path)
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
