"""Kills commands at random moments, and checks what they leave: `python tests/kills.py --count 60`.

After KILL, TERM or INT no file is half written, nothing that was finished is lost, and the next run
of the same command succeeds. TERM and INT end with one sentence.
"""

import argparse
import csv
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from activesuit.assets import curves_path
from helpers import PATIENCE

PROGRAM = (sys.executable, "-m", "activesuit.scripts.main")
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
SWARM = ["--method", "mpso", "--trials", "6", "--workers", "1"]
SMALL = [
    *("--tasks", "ElbowFlexion", "--policies", "none", "--levels", "nominal"),
    *("--motions", "8", "--workers", "1"),
]
TRAIN = ["train", "--algo", "ppo"]


@dataclass(frozen=True)
class Command:
    """A command that is killed.

    Attributes:
        first: Arguments of a run in a new folder, without --out.
        again: Arguments of the next run in the same folder, after a first one that finished.
        file: Name of the file that --out is, in the folder; empty if --out is the folder.
        option: Name of --out.
    """

    first: list[str]
    again: list[str]
    file: str = ""
    option: str = "--out"


def same(*arguments: str) -> Command:
    """Returns a command that is run again over what it wrote."""
    return Command([*arguments], [*arguments, "--force"])


COMMANDS = {
    "identify": same("identify", str(curves_path("elbow")), *SWARM),
    "benchmark": Command(["benchmark", "run", *SMALL], ["benchmark", "run", *SMALL]),
    "demo": same("demo", "--trials", "2", "--motions", "8"),
    "train": Command([*TRAIN, "--steps", "8192"], [*TRAIN, "--steps", "16384", "--resume"]),
    "evaluate": same("evaluate", "--policies", "none", "feedforward", "--motions", "8"),
    "simulate": same("simulate"),
    "view": Command(["view"], ["view", "--force"], "motion.gif", "--film"),
}
QUICK = ("identify",)


def start(arguments: list[str], command: Command, folder: Path) -> subprocess.Popen[str]:
    """Starts a command that writes into `folder`."""
    return subprocess.Popen(
        [*PROGRAM, *arguments, command.option, str(folder / command.file)],
        cwd=folder.parent,
        env={**os.environ, "XDG_STATE_HOME": str(state_of(folder))},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def state_of(folder: Path) -> Path:
    """Returns the folder of what a command notes outside its run folder."""
    return folder.with_name(f"{folder.name}-state")


def finish(arguments: list[str], command: Command, folder: Path) -> tuple[int, str]:
    """Runs a command to its end; returns the exit code and what it said on stderr."""
    process = start(arguments, command, folder)
    _, message = process.communicate(timeout=PATIENCE)
    return process.returncode, message


def half_written(folder: Path) -> list[str]:
    """Returns the names of files that cannot be read; scratch files are not looked at."""
    bad = []
    for path in sorted(folder.rglob("[!.]*")):
        if path.is_file() and not any(part.startswith(".") for part in _inside(path, folder).parts):
            try:
                READERS.get(path.suffix, Path.read_bytes)(path)
            except Exception as error:  # whatever a reader of that kind of file raises
                bad.append(f"{_inside(path, folder)}: {type(error).__name__}: {error}")
    return bad


def finished(folder: Path) -> Counter[str]:
    """Returns the files of a folder, and how much of what takes long is in them."""
    found = Counter(str(_inside(path, folder)) for path in folder.rglob("[!.]*") if path.is_file())
    if (folder / "fits.json").exists():
        fits = json.loads((folder / "fits.json").read_text())
        found["fits"] = sum(map(len, fits.values()))
    if (folder / "model.zip").exists():
        with zipfile.ZipFile(folder / "model.zip") as model:
            found["steps"] = json.loads(model.read("data"))["num_timesteps"]
    return Counter({name: n for name, n in found.items() if "tensorboard" not in name})


class Attack:
    """Random kills of the commands.

    Args:
        names: Names of the commands.
        seed: Seed of the moments, signals and folders.
        scratch: Folder to work in.
    """

    def __init__(self, names: tuple[str, ...], seed: int, scratch: Path) -> None:
        self._rng = random.Random(seed)
        self._names, self._scratch = names, scratch
        self._seconds: dict[str, float] = {}

    def prepare(self, name: str) -> Path:
        """Returns the folder of a run that finished, which takes place once."""
        folder = self._scratch / f"{name}-finished"
        if name not in self._seconds:
            folder.mkdir()
            state_of(folder).mkdir()
            begin = time.monotonic()
            code, message = finish(COMMANDS[name].first, COMMANDS[name], folder)
            assert code == 0, message
            self._seconds[name] = time.monotonic() - begin
        return folder

    def kill_one(self, number: int) -> tuple[str, list[str]]:
        """Kills one command; returns what was done, and what was wrong afterwards."""
        name = self._names[number % len(self._names)]
        sign = self._rng.choice(SIGNALS)
        again = self._rng.random() < 0.5
        ready, command = self.prepare(name), COMMANDS[name]
        moment = self._rng.uniform(0.15, 1.0) * self._seconds[name]
        folder = self._scratch / f"{number}-{name}"
        if again:
            shutil.copytree(ready, folder)
            shutil.copytree(state_of(ready), state_of(folder), dirs_exist_ok=True)
        else:
            folder.mkdir()
        before = finished(folder)
        process = start(command.again if again else command.first, command, folder)
        time.sleep(moment)
        process.send_signal(sign)
        _, message = process.communicate(timeout=PATIENCE)
        wrong = [f"half written: {one}" for one in half_written(folder)]
        wrong += [f"lost: {one}" for one in (before - finished(folder))]
        wrong += _bad_end(process.returncode, message, sign)
        kept = finished(folder)
        code, message = self._next_run(command, folder, kept)
        wrong += [f"the next run failed: {message}"] * (code != 0)
        wrong += [
            f"missing after the next run: {one}" for one in finished(ready) - finished(folder)
        ]
        shutil.rmtree(folder)
        shutil.rmtree(state_of(folder), ignore_errors=True)
        where = "finished" if again else "new"
        said = f"{name:9} {sign.name:8} at {moment:5.1f} s in a {where} folder"
        return f"{said}: exit code {process.returncode}", wrong

    def _next_run(self, command: Command, folder: Path, kept: Counter[str]) -> tuple[int, str]:
        begun = kept["model.zip"] if "--resume" in command.again else True
        arguments = command.again if begun else [*command.first, "--force"]
        if kept["steps"] >= 16384:
            arguments = [*TRAIN, "--steps", "24576", "--resume"]
        return finish(arguments, command, folder)


def attack(names: tuple[str, ...], count: int, seed: int, say: Callable[[str], object]) -> int:
    """Kills `count` commands; returns how many of them left something wrong."""
    bad = 0
    # In the background a shell lets programs ignore Ctrl-C, which they pass on to their children.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with tempfile.TemporaryDirectory() as scratch:
        runner = Attack(names, seed, Path(scratch))
        for number in range(count):
            reported, wrong = runner.kill_one(number)
            bad += bool(wrong)
            say("\n    ".join([f"{number:3} {reported}", *wrong]))
        written = [path.name for path in Path(scratch).iterdir() if path.is_file()]
        if written:  # MUJOCO_LOG.TXT was one
            bad += 1
            say(f"in the working folder: {written}")
    return bad


def _bad_end(code: int, message: str, sign: signal.Signals) -> list[str]:
    """Returns what is wrong about the end of a process that got a signal."""
    if code == 0 or (sign == signal.SIGKILL and code == -sign):
        return []
    last = message.strip().splitlines()[-1:]
    if code == 2 and "Traceback" not in message and last and "interrupted" in last[0]:
        return []
    if code == -sign and "scripts/main.py" not in message and "interrupted" not in message:
        return []  # the signal came before the program began, or after its end
    return [f"exit code {code}: {message[-2000:]}"]


def _inside(path: Path, folder: Path) -> Path:
    return path.relative_to(folder)


def _read_csv(path: Path) -> None:
    with path.open(newline="") as file:
        lines = [row for row in csv.reader(file) if row and not row[0].startswith("#")]
    assert len({len(row) for row in lines}) == 1, "rows of several lengths"


def _read_picture(path: Path) -> None:
    from PIL import Image

    with Image.open(path) as picture:
        for frame in range(getattr(picture, "n_frames", 1)):
            picture.seek(frame)
            picture.load()


def _read_zip(path: Path) -> None:
    with zipfile.ZipFile(path) as file:
        assert file.testzip() is None


READERS: dict[str, Callable[[Path], object]] = {
    ".json": lambda path: json.loads(path.read_text()),
    ".csv": _read_csv,
    ".png": _read_picture,
    ".gif": _read_picture,
    ".svg": ElementTree.parse,
    ".zip": _read_zip,
}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Kills commands at random moments.")
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--commands", nargs="+", default=[*COMMANDS], choices=[*COMMANDS])
    given = parser.parse_args()
    wrong = attack(
        tuple(given.commands), given.count, given.seed, lambda text: print(text, flush=True)
    )
    print(f"{given.count} kills, {wrong} with something wrong")
    sys.exit(wrong > 0)
