"""The cache of compiled kernels, and a message while a first use fills it.

Numba compiles a kernel when it is first called and caches the machine code on disk. On a new
machine that takes up to a minute, and nothing else would show that the program is running. Who may
write to the cache decides what code runs, as with the keys of ssh.
"""

import os
import stat
import sys
import time
from typing import Any

from numba import njit
from numba.core import event
from numba.core.caching import IndexDataCacheFile

from ..errors import InputError, shown

CACHE = "NUMBA_CACHE_DIR"

PATIENCE = 2.0  # [s], compile time before the message
LONGER = 2.5  # times the compile time of a report, until the next one
MESSAGE = (
    "activesuit: compiling kernels for their first use, up to a minute; they are cached on disk "
    f"({CACHE} chooses where)"
)


class FirstUse(event.Listener):
    """Adds up the compile time of our kernels, and reports when it becomes long.

    Attributes:
        done: Number of kernels that are compiled.
    """

    def __init__(self) -> None:
        self.done = 0
        self._depth, self._begun, self._before = 0, 0.0, 0.0
        self._next = PATIENCE

    def on_start(self, event: Any) -> None:
        """Notes that a function begins to compile; a function compiles what it calls inside."""
        if not self._depth:
            self._begun = time.monotonic()
        self._depth += 1
        self._speak()

    def on_end(self, event: Any) -> None:
        """Notes that a function is compiled."""
        self.done += 1
        self._speak()
        self._depth = max(self._depth - 1, 0)
        if not self._depth:
            self._before += time.monotonic() - self._begun

    def _speak(self) -> None:
        spent = self._before + time.monotonic() - self._begun
        if spent <= self._next:
            return
        first, self._next = self._next == PATIENCE, LONGER * spent
        said = f"activesuit: {self.done} kernels are compiled after {spent:.0f} s of compilation"
        print(MESSAGE if first else said, file=sys.stderr, flush=True)


def check_cache() -> None:
    """Checks that there is a cache of kernels, and that nobody else can put code into it."""
    folder = os.environ.get(CACHE, "")
    if os.name == "posix" and os.path.isdir(folder):
        found = os.stat(folder)
        if found.st_uid not in (0, os.getuid()) or found.st_mode & stat.S_IWOTH:
            raise InputError(
                f"{CACHE} is {shown(folder)}, where other users may write, and its files are code "
                "that runs: choose a folder of your own, or take their right to write (chmod o-w)"
            )
    try:
        cache_folder()
    except RuntimeError as error:
        raise InputError(
            "there is no folder for the machine code of kernels, neither beside the package nor in "
            f"a home folder: set {CACHE} to a folder that you may write"
        ) from error


def cache_folder() -> str:
    """Returns the folder of the machine code of this module, beside those of the others.

    Raises:
        RuntimeError: There is no folder that this user may write to.
    """
    return str(njit(cache=True)(_nothing).stats.cache_path)


def _nothing() -> None:
    pass


_read_index: Any = getattr(IndexDataCacheFile, "_load_index", None)  # not public


def _index_of_today(self: Any) -> dict[Any, str]:
    """Returns what an index of numba's cache lists; nothing if it has types that are gone.

    Numba reads the types before it compares dates, so that an upgrade of this package would end
    with the name of a module that an older version had.
    """
    try:
        return _read_index(self)
    except (ImportError, AttributeError):
        return {}


if _read_index:
    IndexDataCacheFile._load_index = _index_of_today
check_cache()
listener = FirstUse()
event.register("numba:compile", listener)
