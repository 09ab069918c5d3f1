"""A message to the user when a first use has to compile kernels for more than a moment.

Numba compiles a kernel when it is first called and caches the machine code on disk. On a new
machine that takes up to a minute, and nothing else would show that the program is running.
"""

import sys
import time
from typing import Any

from numba.core import event

PATIENCE = 2.0  # [s], compile time before the message
MESSAGE = (
    "activesuit: compiling kernels for their first use, up to a minute; they are cached on disk "
    "(NUMBA_CACHE_DIR chooses where)"
)


class FirstUse(event.Listener):
    """Adds up the compile time of our kernels, and reports once when it becomes long.

    Attributes:
        silent: Whether no (further) message is printed.
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
