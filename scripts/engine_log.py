"""Warnings of MuJoCo: printed once at the end of a command, not logged in the working folder."""

import re
import sys
from collections import Counter, deque
from collections.abc import Iterator
from contextlib import contextmanager

from ..text import say

MOST = 10_000  # warnings that are kept, the last ones
_TIME = re.compile(r"\s*Time = \S+$")


@contextmanager
def engine_warnings() -> Iterator[None]:
    """Collects MuJoCo's warnings in the block, and prints each kind once on stderr at the end.

    By default MuJoCo appends each warning to MUJOCO_LOG.TXT in the working folder. Nothing happens
    if MuJoCo has not been imported.
    """
    mujoco = sys.modules.get("mujoco")
    if mujoco is None:
        yield
        return
    kept: deque[str] = deque(maxlen=MOST)
    before = mujoco.get_mju_user_warning()
    # No Python function: Ctrl-C inside a Python function that MuJoCo calls would end the process.
    mujoco.set_mju_user_warning(kept.append)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
        for text, times in Counter(_TIME.sub("", text) for text in kept).items():
            often = f" ({times} times)" if times > 1 else ""
            say(f"activesuit: warning of MuJoCo{often}: {text}", file=sys.stderr)
