"""C programs of tests, which are skipped where there is no C compiler."""

from pathlib import Path

import pytest
from activesuit.benchmarks import device
from activesuit.benchmarks.device import answers

__all__ = ["answers", "compiled", "need_compiler"]


def need_compiler() -> None:
    """Skips the test where there is no C compiler."""
    if device.compiler() is None:
        pytest.skip("there is no C compiler: neither cc, nor gcc, nor clang")


def compiled(folder: Path, source: str, kind: str = "double", name: str = "program") -> Path:
    """Compiles a program without a warning, with "float" or "double" numbers."""
    need_compiler()
    return device.compiled(folder, source, kind, name)
