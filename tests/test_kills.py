"""Commands that are killed at a random moment leave whole files, and the next run succeeds.

After KILL, TERM or INT no file is half written and no finished file is lost. TERM and INT end with
one sentence. `KILLS=10 python -m pytest tests/test_kills.py` kills each command ten times.
"""

import csv
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest
from activesuit.assets import curves_path
from helpers import PATIENCE

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
SMALL = "--tasks ElbowFlexion --policies none --levels nominal --motions 8 --workers 1"
TRAIN = "train --algo ppo --out {} --steps"
COMMANDS = {  # the command, and the next run in the same folder
    "identify": (
        f"identify {curves_path('elbow')} --method mpso --trials 6 --workers 1 --out {{}}",
        " --force",
    ),
    "benchmark": (f"benchmark run {SMALL} --out {{}}", ""),
    "demo": ("demo --trials 2 --motions 8 --out {}", " --force"),
    "train": (f"{TRAIN} 8192", ""),
    "evaluate": ("evaluate --policies none feedforward --motions 8 --out {}", " --force"),
    "simulate": ("simulate --out {}", " --force"),
    "view": ("view --film {}/motion.gif", " --force"),
}
COUNT = int(os.environ.get("KILLS", "0"))
CASES = [(name, seed) for name in COMMANDS for seed in range(COUNT)] or [("identify", 0)]


def read_csv(path: Path) -> None:
    with path.open(newline="") as file:
        lines = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    assert len({len(row) for row in lines}) == 1, "rows of several lengths"


def read_picture(path: Path) -> None:
    from PIL import Image

    with Image.open(path) as picture:
        for frame in range(getattr(picture, "n_frames", 1)):
            picture.seek(frame)
            picture.load()


def read_zip(path: Path) -> None:
    with zipfile.ZipFile(path) as file:
        assert file.testzip() is None


READERS: dict[str, Callable[[Path], object]] = {
    ".json": lambda path: json.loads(path.read_text()),
    ".csv": read_csv,
    ".png": read_picture,
    ".gif": read_picture,
    ".svg": ElementTree.parse,
    ".zip": read_zip,
}


def start(command: str, folder: Path) -> subprocess.Popen[str]:
    """Starts a command that writes into a folder."""
    return subprocess.Popen(
        [sys.executable, "-m", "activesuit.scripts.main", *command.format(folder).split()],
        cwd=folder.parent,
        env={**os.environ, "XDG_STATE_HOME": f"{folder}-state"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def finish(command: str, folder: Path) -> None:
    process = start(command, folder)
    _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said


def finished(folder: Path) -> Counter[str]:
    """Reads all files that are no scratch files; returns their names, and counts of results."""
    found: Counter[str] = Counter()
    for path in folder.rglob("[!.]*"):
        name = path.relative_to(folder)
        if path.is_file() and not any(part.startswith(".") for part in name.parts):
            READERS.get(path.suffix, Path.read_bytes)(path)
            found[str(name)] += "tensorboard" not in name.parts
    if "fits.json" in found:
        found["fits"] = sum(map(len, json.loads((folder / "fits.json").read_text()).values()))
    if "model.zip" in found:
        with zipfile.ZipFile(folder / "model.zip") as model:
            found["steps"] = json.loads(model.read("data"))["num_timesteps"]
    return found


@pytest.fixture(scope="module")
def ready(tmp_path_factory):
    """Returns the folder of a finished run of a command, and the duration of the run [s]."""
    made: dict[str, tuple[Path, float]] = {}

    def run(name: str) -> tuple[Path, float]:
        if name not in made:
            folder = tmp_path_factory.mktemp(name) / "out"
            folder.mkdir()
            begin = time.monotonic()
            finish(COMMANDS[name][0], folder)
            made[name] = folder, time.monotonic() - begin
        return made[name]

    return run


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), CASES)
def test_a_killed_command_leaves_whole_files(name, seed, ready, tmp_path, monkeypatch):
    # A shell lets programs in the background ignore Ctrl-C, which they pass on to their children.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    rng = random.Random(seed)
    sign, again, moment = rng.choice(SIGNALS), rng.random() < 0.5, rng.uniform(0.15, 1.0)
    (whole, seconds), folder = ready(name), tmp_path / "out"
    (command, more), state = COMMANDS[name], f"{folder}-state"
    following = f"{TRAIN} 16384 --resume" if name == "train" else command + more
    if again:
        shutil.copytree(whole, folder)
        if Path(f"{whole}-state").exists():
            shutil.copytree(f"{whole}-state", state)
    else:
        folder.mkdir()
    before = finished(folder)
    process = start(following if again else command, folder)
    time.sleep(moment * seconds)
    process.send_signal(sign)
    _, said = process.communicate(timeout=PATIENCE)
    left = finished(folder)
    assert not before - left, "lost"
    interrupted = "interrupted" in (said.strip().splitlines() or [""])[-1]
    outside = "scripts/main.py" not in said  # before the program began, or after its end
    good = process.returncode == 2 and interrupted and "Traceback" not in said
    assert good or process.returncode == 0 or (process.returncode == -sign and outside), said
    if name == "train" and left["steps"] >= 16384:
        following = f"{TRAIN} 24576 --resume"
    begun = "model.zip" in left or name != "train"
    finish(following if begun else f"{command} --force", folder)
    assert not finished(whole) - finished(folder), "missing after the next run"
    assert {path.name for path in tmp_path.iterdir()} <= {"out", "out-state"}
