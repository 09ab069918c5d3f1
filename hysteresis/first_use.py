"""A word to the user when the first use of something compiles for longer than a moment.

Numba compiles a kernel when it is first called and caches the machine code on disk. On a new
machine that takes up to a minute, in which nothing else would tell that the program is alive.
"""

import sys
import time
from typing import Any

from numba.core import event

PATIENCE = 2.0  # s of compiling before a word is said
MESSAGE = (
    "activesuit: compiling kernels for their first use, up to a minute; they are cached on disk "
    "(NUMBA_CACHE_DIR chooses where)"
)


class FirstUse(event.Listener):
    """Adds up how long our kernels compile, and says so once when it takes long.

    Attributes:
        silent: Whether it has nothing (more) to say.
    """

    def __init__(self) -> None:
        self.silent = False
        self._depth, self._begun, self._before = 0, 0.0, 0.0

    def on_start(self, event: Any) -> None:
        """Notes that a function begins to compile; a function compiles what it calls inside."""
        if not self._depth:
            self._begun = time.monotonic()
        self._depth += 1
        self._speak()

    def on_end(self, event: Any) -> None:
        """Notes that a function is compiled."""
        self._speak()
        self._depth = max(self._depth - 1, 0)
        if not self._depth:
            self._before += time.monotonic() - self._begun

    def _speak(self) -> None:
        if not self.silent and self._before + time.monotonic() - self._begun > PATIENCE:
            self.silent = True
            print(MESSAGE, file=sys.stderr, flush=True)


listener = FirstUse()
event.register("numba:compile", listener)
