"""The cache of compiled kernels, and a message while a first use fills it.

Numba compiles a kernel at its first call and caches the machine code on disk. On a new machine the
compilation takes up to a minute, in which nothing else would show that the program is running. A
user who may write to the cache decides which code runs, so the cache must be private.
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
    """Counts compiled kernels (`done`), and prints a message when their compile time is long."""

    def __init__(self) -> None:
        self.done, self._depth, self._begun, self._before = 0, 0, 0.0, 0.0
        self._next = PATIENCE

    def on_start(self, event: Any) -> None:
        """Starts the clock, unless the compilation of a calling function has started it."""
        if not self._depth:
            self._begun = time.monotonic()
        self._depth += 1
        self._report()

    def on_end(self, event: Any) -> None:
        """Counts a compiled function, and stops the clock after the outermost function."""
        self.done += 1
        self._report()
        self._depth = max(self._depth - 1, 0)
        if not self._depth:
            self._before += time.monotonic() - self._begun

    def _report(self) -> None:
        spent = self._before + time.monotonic() - self._begun
        if spent <= self._next:
            return
        first, self._next = self._next == PATIENCE, LONGER * spent
        words = f"activesuit: {self.done} kernels are compiled after {spent:.0f} s of compilation"
        print(MESSAGE if first else words, file=sys.stderr, flush=True)


def check_cache() -> None:
    """Checks that there is a cache of kernels, and that no other user can write to the cache."""
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
    """Returns the folder of this module's machine code; a RuntimeError says that there is none."""
    return str(njit(cache=True)(_nothing).stats.cache_path)


def _nothing() -> None:
    pass


_read_index: Any = getattr(IndexDataCacheFile, "_load_index", None)  # not public


def _index_of_today(self: Any) -> dict[Any, str]:
    """Returns the entries of an index of numba's cache; none if the index names a missing type.

    Numba reads the types before the dates, so an upgrade of this package would end in an error
    about a module of an older version.
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
