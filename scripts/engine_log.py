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
    """Keeps MuJoCo's warnings in the block, and prints each kind of them once on stderr at its end.

    Without this, MuJoCo appends every one of them to MUJOCO_LOG.TXT in the working folder. Nothing
    happens if MuJoCo has not been imported.
    """
    mujoco = sys.modules.get("mujoco")
    if mujoco is None:
        yield
        return
    kept: deque[str] = deque(maxlen=MOST)
    before = mujoco.get_mju_user_warning()
    # Not a function in Python: Ctrl-C would be raised in it, inside MuJoCo, and end the process.
    mujoco.set_mju_user_warning(kept.append)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
        _tell(kept)


def _tell(warnings: deque[str]) -> None:
    for text, times in Counter(_TIME.sub("", text) for text in warnings).items():
        often = f" ({times} times)" if times > 1 else ""
        say(f"activesuit: warning of MuJoCo{often}: {text}", file=sys.stderr)
