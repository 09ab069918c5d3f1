"""The C code of models: its difference from Python, its memory and the time of a step."""

import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..arrays import Array
from ..errors import InputError
from ..hysteresis import HysteresisModel, State, Viscoelastic
from ..hysteresis.c_code import BYTES, Header, stepped
from ..scripts.folders import to_json
from ..scripts.output import table
from .references import EXAMPLES

SAMPLES = 10_000
DT = 0.01  # s, time of a step
WIDTHS = (1.0, 0.1, 0.01)  # greatest motions over the range: whole and minor loops
FLAGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic")
NARROW = ("-DACTIVESUIT_FLOAT", "-Wdouble-promotion", "-Wfloat-conversion")  # no slow doubles
PROGRAM = """#include <stdio.h>
#include <time.h>
#include "all.h"
enum {{ SAMPLES = {samples} }};
static all_real angles[SAMPLES], torques[SAMPLES];
static double get(void) {{ double x = 0; return fread(&x, sizeof x, 1, stdin) == 1 ? x : 0; }}
static void put(double x) {{ fwrite(&x, sizeof x, 1, stdout); }}
#define RUN(NAME, DT) {{ \\
    NAME##_state s; \\
    NAME##_init(&s); \\
    for (int i = 0; i < SAMPLES; i++) angles[i] = (all_real)get(); \\
    const clock_t start = clock(); \\
    for (int i = 0; i < SAMPLES; i++) torques[i] = NAME##_step(&s, angles[i] DT); \\
    put(1e9 * (double)(clock() - start) / CLOCKS_PER_SEC / SAMPLES); \\
    put(sizeof s / sizeof(all_real)); \\
    for (int i = 0; i < SAMPLES; i++) put((double)torques[i]); }}
#define TIME , (all_real){dt}
#define NONE
int main(void)
{{
{runs}
    return 0;
}}
"""


@dataclass(frozen=True)
class Found:
    """What a C program found.

    Attributes:
        nanoseconds: Mean time of a step [ns].
        state: Numbers in the state.
        torque: Resistance at each angle [N·m].
    """

    nanoseconds: float
    state: int
    torque: Array


def compiler() -> str | None:
    """Returns the path of a C compiler; None if there is none."""
    return shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


def compiled(folder: Path, source: str, kind: str = "double", name: str = "program") -> Path:
    """Compiles a program without a warning; returns its path.

    Args:
        folder: Folder with the headers that the program includes.
        source: Text of the program.
        kind: Type of the numbers, "float" or "double".
        name: Name of the program.

    Raises:
        InputError: There is no C compiler, or it refuses the program.
    """
    found = compiler()
    if found is None:
        raise InputError("there is no C compiler: install cc, gcc or clang")
    (folder / f"{name}.c").write_text(source, encoding="ascii")
    flags = [*FLAGS, *(NARROW if kind == "float" else ())]
    command = [found, *flags, f"{name}.c", "-o", f"{name}-{kind}", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        raise InputError(f"{found} refuses the program: {done.stderr}")
    return folder / f"{name}-{kind}"


def answers(program: Path, *numbers: Array) -> Array:
    """Returns the numbers that a program prints for numbers on its input."""
    given = b"".join(np.asarray(one, np.float64).tobytes() for one in numbers)
    done = subprocess.run([program], input=given, capture_output=True, check=True)
    return np.frombuffer(done.stdout)


def run_in_c(cases: Mapping[str, tuple[HysteresisModel, State, Array]]) -> dict[str, Any]:
    """Compiles all models into one program, and runs it with numbers of each type.

    Args:
        cases: Model, state at the beginning and `SAMPLES` angles [rad], by name.

    Returns:
        What was found, by type and name.

    Raises:
        InputError: See `compiled`.
    """
    header, runs = Header("all"), []
    for i, (model, state, _) in enumerate(cases.values()):
        header.model(f"as_m{i}", model, state)
        runs.append(f"    RUN(all_m{i}, {'TIME' if isinstance(model, Viscoelastic) else 'NONE'})")
    source = PROGRAM.format(samples=SAMPLES, dt=DT, runs="\n".join(runs))
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "all.h").write_text(header.text(["All models."]), encoding="ascii")
        for kind in BYTES:
            program = compiled(Path(folder), source, kind)
            rows = answers(program, *(angle for _, _, angle in cases.values()))
            found[kind] = {
                name: Found(float(row[0]), int(row[1]), row[2:])
                for name, row in zip(cases, rows.reshape(len(cases), -1), strict=True)
            }
    return found


def motion(low: float, high: float, seed: int = 0) -> Array:
    """Returns angles [rad] that turn at random places, with minor loops, stops and jumps."""
    rng, angle = np.random.default_rng(seed), [low]
    while len(angle) < SAMPLES:
        width = (high - low) * rng.choice(WIDTHS)
        turn = np.clip(angle[-1] + rng.uniform(-width, width), low, high)
        angle += [*np.linspace(angle[-1], turn, rng.integers(2, 120))[1:]]
        angle += [angle[-1]] * int(rng.integers(0, 2))
    return np.array(angle[:SAMPLES])


def device() -> list[dict[str, Any]]:
    """Returns differences, memory and times of the examples of all models.

    Raises:
        InputError: There is no C compiler.
    """
    cases = {}
    for one in (one for examples in EXAMPLES.values() for one in examples):
        start = one.model.start(one.low, one.start_torque)
        cases[one.name] = (one.model, start, motion(one.low, one.high))
    found, rows = run_in_c(cases), []
    for name, (model, state, angle) in cases.items():
        torque = stepped(model, state, angle, DT)
        peak = np.abs(torque).max()
        alone = Header("alone")
        alone.model("as_joint", model, state)
        row: dict[str, Any] = {"model": name, "constants": alone.constants}
        for kind in BYTES:
            one = found[kind][name]
            row["state"] = one.state
            row[kind] = {
                "difference": float(np.abs(one.torque - torque).max() / peak),
                "nanoseconds": one.nanoseconds,
            }
        rows.append(row)
    return rows


def columns(rows: list[dict[str, Any]]) -> tuple[list[str], list[list[str]]]:
    """Returns header and rows of a table of the results of `device`."""
    header = ["model"]
    header += [f"{what},\n{kind}" for what in ("state", "tables") for kind in BYTES]
    header += ["difference,\nfloat", "difference,\ndouble", "time,\nfloat"]
    return header, [
        [
            row["model"],
            *(str(row[what] * size) for what in ("state", "constants") for size in BYTES.values()),
            *(f"{row[kind]['difference']:.0e}" for kind in BYTES),
            f"{row['float']['nanoseconds']:.0f}",
        ]
        for row in rows
    ]


def report(json: bool) -> None:
    """Measures the C code of all models and prints the result as a table or as JSON."""
    rows = device()
    if json:
        print(to_json({"rows": rows}))
        return
    title = "C code: bytes; largest difference from Python over the peak; time of a step [ns]"
    table(title, *columns(rows))
