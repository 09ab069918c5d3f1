"""A second process that compiles the control cycle while the first one compiles the suits.

Both take about as long, and know nothing of each other; each caches its machine code on disk. If
the second process fails, the first one compiles the control cycle itself.
"""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

PROGRAM = "from activesuit.envs import ArmEnv; ArmEnv(suit='none').reset(seed=0)"
ALONE = "ACTIVESUIT_COMPILE_ALONE"  # environment variable: any value forbids the second process

_begun: list[subprocess.Popen] = []  # the second process, if it was started


def begin(kernel: Any) -> None:
    """Starts the second process, unless the control cycle is cached or there is only one core."""
    if _begun or os.environ.get(ALONE) or _is_cached(kernel) or _cores() < 2:
        return
    if not sys.executable or hasattr(sys, "frozen"):  # this program is not the interpreter's
        return
    own = {ALONE: "1", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    _begun.append(
        subprocess.Popen(
            [sys.executable, "-c", PROGRAM],
            env={**os.environ, **own},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    )


def wait() -> None:
    """Waits until the second process, if there is one, has compiled the control cycle."""
    for process in _begun:
        process.wait()


def _is_cached(kernel: Any) -> bool:
    """Returns whether the newest code of a kernel is in numba's cache on disk."""
    source, folder = Path(kernel.py_func.__code__.co_filename), kernel.stats.cache_path
    if folder is None:
        return True  # a second process is of no use then
    indices = Path(folder).glob(f"{source.stem}.{kernel.py_func.__name__}-*.nbi")
    return any(index.stat().st_mtime >= source.stat().st_mtime for index in indices)


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
