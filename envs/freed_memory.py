"""Returns freed memory to the system, which the C library would keep for the process."""

import ctypes
import sys
import weakref


def give_back() -> None:
    """Returns freed memory to the system, if the C library can.

    glibc keeps freed memory: without this call, fifty environments would occupy their memory after
    they are deleted.
    """
    if sys.platform.startswith("linux"):
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # musl has no such function
        if trim is not None:
            trim(0)


def give_back_after(owner: object) -> None:
    """Calls `give_back` when `owner` has been collected."""
    weakref.finalize(owner, give_back).atexit = False
