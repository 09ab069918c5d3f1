"""Runs the examples of docs/commands.md: `python -m activesuit.tools.examples`.

They run in their order in one new folder, with files of the names that they use, and as small as
their options allow.
"""

import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..assets import JOINTS
from ..identification import load_curves
from ..scripts.main import command_of

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "commands.md"
CURVES = ROOT / "assets" / "curves" / "elbow.csv"
ELSEWHERE = {  # how examples begin that are not run here, and why
    "demo": "make demo-check runs it from the wheel",
    "view --task": "it needs a display",
}
SMALL = (  # command, further words of an example, and options beside its own or instead of them
    ("identify", "auto", ["--samples", "2"]),
    ("evaluate", "", ["--motions", "8"]),
    ("validate", "", ["--motions", "8"]),
    ("benchmark", "run", ["--tasks", "ElbowFlexion", "--levels", "nominal", "--motions", "8"]),
    ("train", "", ["--steps", "8192"]),
    ("train", "--resume", ["--steps", "16384"]),
    ("train", "--seeds", ["--seeds", "0,1"]),
    ("view", "--film", ["--max-episode-steps", "100", "--size", "320", "240"]),
)
SECONDS = 600  # longest time of an example


def examples() -> Iterator[list[str]]:
    """Yields the words of every command in the shell blocks of the page."""
    text = PAGE.read_text(encoding="utf-8")
    for block in re.findall(r"^```bash\n(.*?)^```$", text, re.DOTALL | re.MULTILINE):
        for line in re.findall("^activesuit (.+)", block, re.MULTILINE):
            yield shlex.split(line, comments=True)


def small(words: Sequence[str]) -> list[str]:
    """Returns an example with the options of `SMALL`, in place of its own where it has them."""
    found, name = list(words), command_of(words)[0]
    for command, word, options in SMALL:
        if command == name and (not word or word in words):
            starts = [i for i, word in enumerate(options) if word.startswith("--")]
            for begin, end in zip(starts, [*starts[1:], len(options)], strict=True):
                found = _without(found, options[begin]) + options[begin:end]
    return found


def _without(words: Sequence[str], option: str) -> list[str]:
    if option not in words:
        return list(words)
    begin = words.index(option)
    end = begin + 1
    while end < len(words) and not words[end].startswith("--"):
        end += 1
    return [*words[:begin], *words[end:]]


def prepare(folder: Path) -> None:
    """Puts the files into a folder that the examples call mine."""
    shutil.copy(CURVES, folder / "my-curves.csv")
    curve = load_curves(CURVES)[0]
    rows = zip(np.degrees(curve.angle), 2 * curve.torque, strict=True)
    lines = ["Winkel 1 [Grad];CH2 [V]", *(f"{angle:.3f};{volts:.4f}" for angle, volts in rows)]
    (folder / "rig.csv").write_text("\n".join(lines).replace(".", ","), encoding="utf-8")
    now = np.arange(0, 2, 0.02)
    angle = np.full((now.size, len(JOINTS)), [0, 0.6, 1.0, 0]) + 0.1 * np.sin(now)[:, None] ** 2
    names, motion = ",".join(["time", *JOINTS]), np.column_stack([now, angle])
    np.savetxt(folder / "my-motion.csv", motion, "%.6f", ",", header=names, comments="")


def main() -> None:
    """Runs all of them; exits with code 1 after the first that fails."""
    with tempfile.TemporaryDirectory() as folder:
        prepare(Path(folder))
        for words in examples():
            line = shlex.join(words)
            elsewhere = [why for start, why in ELSEWHERE.items() if line.startswith(start)]
            if elsewhere:
                print(f"activesuit {line}: {elsewhere[0]}", flush=True)
                continue
            short, begin = small(words), time.monotonic()
            command = [sys.executable, "-m", "activesuit.scripts.main", *short]
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, timeout=SECONDS, check=False
            )
            taken = time.monotonic() - begin
            print(f"activesuit {shlex.join(short)}: {taken:.0f} s", flush=True)
            if done.returncode:
                sys.exit(f"it ended with code {done.returncode}:\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    main()
