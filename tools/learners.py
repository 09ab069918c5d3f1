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

import numpy as np

from .. import __version__
from ..envs.making import make_arms
from ..errors import InputError
from ..files import write_text
from ..json_files import read_json
from .measure import FOLDER, condensed

PROGRAMS = FOLDER.parent / "learners"
BESIDE = ("none", "gravity", "compensation")
LINE = re.compile(r"(\d+) steps: mean reward (\d\.\d+)")
SHORT, SEEDS = 73, (0, 1, 2)  # updates of 4096 steps, of a comparison of seeds
NOISES = (1.0, 0.08)  # standard deviations of actions


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
    """Trains and scores a learner; returns versions, mean rewards and relief.

    Args:
        name: Name of the learner, one of `LEARNERS`.
        python: Interpreter that runs its program.
    """
    learner = LEARNERS[name]
    text = (PROGRAMS / learner.program).read_text(encoding="utf-8")
    ask = "import importlib.metadata, sys; print(*map(importlib.metadata.version, sys.argv[1:]))"
    versions = [
        version.partition("+")[0]  # without the kind of build, as +cpu
        for version in _run([python, "-c", ask, *learner.packages], Path.cwd()).split()
    ]
    found: dict[str, Any] = {"versions": dict(zip(learner.packages, versions, strict=True))}
    found |= _trained(text, learner.policy, python, BESIDE)
    if name == "torch":
        found["seeds"] = {
            str(seed): _trained(_short(text, seed), learner.policy, python)["relief"]
            for seed in SEEDS
        }
        found["noise"] = {str(size): _reward_of_noise(size) for size in NOISES}
    return condensed(found)


def _trained(
    text: str, policy: str, python: str, beside: tuple[str, ...] = BESIDE[:1]
) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "program.py").write_text(text, encoding="utf-8")
        printed = _run([python, "program.py"], folder)
        command = [sys.executable, "-m", "activesuit.scripts.main", "evaluate"]
        _run([*command, "--policies", *beside, policy, "--out", "run"], folder)
        scores = read_json(folder / "run" / "result.json", "result")["scores"]
    rewards = {steps: float(reward) for steps, reward in LINE.findall(printed)}
    relief = {name: scores[name]["relief"] for name in (*beside, policy)}
    return {"rewards": rewards, "relief": relief}


def _short(text: str, seed: int) -> str:
    """Returns a program with fewer updates and another seed."""
    changes = {
        "UPDATES, ROWS, PERIODS = 245,": f"UPDATES, ROWS, PERIODS = {SHORT},",
        "torch.manual_seed(0)": f"torch.manual_seed({seed})",
        "arms.reset(seed=0)": f"arms.reset(seed={64 * seed})",
    }
    for old, new in changes.items():
        if old not in text:
            raise InputError(f"the program has no {old!r}: change it there and here")
        text = text.replace(old, new)
    return text


def _reward_of_noise(size: float) -> float:
    """Returns the mean reward of normal noise around no torque, over an episode of 64 rows."""
    arms, random = make_arms("ActiveSuit/ElbowFlexion-v0", 64), np.random.default_rng(0)
    arms.reset(seed=0)
    rewards = []
    for _ in range(round(arms.duration / arms.control_dt)):
        action = np.clip(random.normal(scale=size, size=arms.action_space.shape), -1, 1)
        rewards.append(arms.step(action)[1])
    return float(np.mean(rewards))


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
