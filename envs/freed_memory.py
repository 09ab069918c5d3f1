"""Gives freed memory back to the system, which the C library would keep for the process."""

import ctypes
import sys
import weakref
from collections.abc import Callable
from functools import cache


def give_back() -> None:
    """Returns freed memory to the system, if the C library can.

    glibc keeps freed memory: fifty environments would occupy theirs after they are deleted.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


def give_back_after(owner: object) -> None:
    """Calls `give_back` when `owner` has been collected."""
    weakref.finalize(owner, give_back).atexit = False


@cache
def _trim() -> Callable[[int], int] | None:
    if not sys.platform.startswith("linux"):
        return None
    return getattr(ctypes.CDLL(None), "malloc_trim", None)  # musl has none
