"""The record of a run folder: whose it is, which files that command wrote, and a lock."""

import os
import stat
import sys
import weakref
from pathlib import Path

from ..errors import InputError

RECORD = ".activesuit"
FIRST_LINE = "activesuit "  # the command's name follows; each other line names a file it wrote
LONGEST = 1 << 20  # bytes of a record; a longer one is not ours
FEW = 3  # names of foreign files in a sentence


class Record:
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
