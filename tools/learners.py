"""Measures the learners that docs/training.md reports: `python -m activesuit.tools.learners NAME`.

A learner trains by its program in docs/learners, and `activesuit evaluate` scores what it has
learned. TorchRL and RLlib need environments of their own, whose interpreters `--python` names. The
results are kept in docs/measured.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

from .. import __version__
from ..files import write_text
from ..json_files import read_json
from .measure import FOLDER, condensed

PROGRAMS = FOLDER.parent / "learners"
BESIDE = ("none", "gravity", "compensation")
LINE = re.compile(r"(\d+) steps: mean reward (\d\.\d+)")


class Learner(NamedTuple):
    """A learner of docs/learners: its program, the policy that this saves, and packages."""

    program: str
    policy: str
    packages: dict[str, str]


LEARNERS = {
    "torch": Learner("ppo.py", "my-ppo", {"torch": "torch", "gymnasium": "Gymnasium"}),
    "torchrl": Learner(
        "with_torchrl.py",
        "my-torchrl",
        {"torchrl": "TorchRL", "torch": "torch", "gymnasium": "Gymnasium"},
    ),
    "rllib": Learner(
        "with_rllib.py",
        "my-rllib",
        {"ray": "Ray", "torch": "torch", "gymnasium": "Gymnasium"},
    ),
}


def kept_learner(name: str) -> dict[str, Any]:
    """Returns the kept result of a learner, one of `LEARNERS`."""
    return read_json(FOLDER / f"learner-{name}.json", "kept result")


def measured(name: str, python: str) -> dict[str, Any]:
    """Trains and scores a learner; returns versions, mean rewards and scores.

    Args:
        name: Name of the learner, one of `LEARNERS`.
        python: Interpreter that runs its program.
    """
    learner = LEARNERS[name]
    ask = "import importlib.metadata, sys; print(*map(importlib.metadata.version, sys.argv[1:]))"
    versions = [
        version.partition("+")[0]  # without the kind of build, as +cpu
        for version in _run([python, "-c", ask, *learner.packages], Path.cwd()).split()
    ]
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        printed = _run([python, str(PROGRAMS / learner.program)], folder)
        command = [sys.executable, "-m", "activesuit.scripts.main", "evaluate"]
        _run([*command, "--policies", *BESIDE, learner.policy, "--out", "run"], folder)
        scores = read_json(folder / "run" / "result.json", "result")["scores"]
    return condensed(
        {
            "versions": dict(zip(learner.packages, versions, strict=True)),
            "rewards": {steps: float(reward) for steps, reward in LINE.findall(printed)},
            "scores": scores,
        }
    )


def _run(command: list[str], folder: Path) -> str:
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run(command, cwd=folder, env=environment, stdout=subprocess.PIPE, check=True)
    return done.stdout.decode()


def main() -> None:
    """Measures one learner, and keeps the result."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=LEARNERS)
    parser.add_argument("--python", default=sys.executable, help="interpreter of the learner")
    given = parser.parse_args()
    learner = LEARNERS[given.name]
    commands = [
        f"python docs/learners/{learner.program}",
        f"activesuit evaluate --policies {' '.join(BESIDE)} {learner.policy}",
    ]
    content: dict[str, Any] = {"commands": commands, "version": __version__}
    content["result"] = measured(given.name, given.python)
    text = json.dumps(content, indent=1, ensure_ascii=False)
    write_text(FOLDER / f"learner-{given.name}.json", f"{text}\n")


if __name__ == "__main__":
    main()
