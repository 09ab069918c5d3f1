"""Compiles headers with C programs that tests write, and runs them."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

FLAGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic")
NARROW = ("-DACTIVESUIT_FLOAT", "-Wdouble-promotion", "-Wfloat-conversion")  # no slow doubles


def compiler() -> str:
    """Returns the C compiler; skips the test where there is none."""
    found = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if found is None:
        pytest.skip("there is no C compiler: neither cc, nor gcc, nor clang")
    return found


def compiled(folder: Path, source: str, kind: str = "double", name: str = "program") -> Path:
    """Compiles a program without a warning, with "float" or "double" numbers.

    Args:
        folder: Folder with the headers that the program includes.
        source: Text of the program.
        kind: Type of the numbers.
        name: Name of the program.
    """
    (folder / f"{name}.c").write_text(source, encoding="ascii")
    flags = [*FLAGS, *(NARROW if kind == "float" else ())]
    command = [compiler(), *flags, f"{name}.c", "-o", f"{name}-{kind}", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / f"{name}-{kind}"


def answers(program: Path, *numbers: np.ndarray) -> np.ndarray:
    """Returns the doubles that a program prints for doubles on its input."""
    given = b"".join(np.asarray(one, np.float64).tobytes() for one in numbers)
    return np.frombuffer(
        subprocess.run([program], input=given, capture_output=True, check=True).stdout
    )
