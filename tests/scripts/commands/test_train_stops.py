"""Trainings that are stopped after any of their files, and go on to the same end."""

import hashlib
import json
from itertools import count

import pytest
from activesuit import files
from activesuit.scripts.main import main
from activesuit.scripts.training import evaluations as evaluations_module
from activesuit.scripts.training.evaluations import Evaluations
from activesuit.scripts.training.run import finished
from helpers import shorten_tasks

pytest.importorskip("stable_baselines3")
from activesuit.scripts.training import learn

pytestmark = pytest.mark.slow

ROWS = 8
SMALL = f"n_envs: {ROWS}, batch_size: 16, learning_rate: 1e-3"
LEARNERS = {
    "ppo": f"{{{SMALL}, n_steps: 4, n_epochs: 2, use_sde: true, sde_sample_freq: 3}}",
    "sac": f"{{{SMALL}, buffer_size: 300, learning_starts: 40, gradient_steps: 1}}",
}
PERIODS = 30  # control periods of a motion
FILES = ("policy.safetensors", "policy.json", "evaluations.json")


class Killed(BaseException):
    """As by kill -9: nothing that the training does afterwards sees it."""


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Short motions, three checkpoints, and evaluations that follow from the weights alone."""
    monkeypatch.setattr(learn, "CHECKPOINTS", 3)
    monkeypatch.setattr(Evaluations, "evaluated", by_weights)
    shorten_tasks(monkeypatch, PERIODS / 100)


def by_weights(evaluations, network):
    weights = b"".join(one.tobytes() for one in network.weights.values())
    value = hashlib.sha256(weights).digest()[0] / 256
    return {"relief": {"value": value, "low": value, "high": value}, "success": 1.0}


def options(tmp_path, name):
    given = ["--task", "ArmTracking", "--motions", "8", "--rows", str(ROWS)]
    if name == "student":
        return [*given, "--teacher", "compensation", "--steps", str(3 * ROWS * PERIODS)]
    file = tmp_path / "small.yml"
    file.write_text(f"default: {LEARNERS[name]}")
    return [*given, "--algo", name, "--steps", "96", "--hyperparameters", str(file)]


def stop_after(monkeypatch, out, moves, stop):
    """Makes a training stop when it has put its `moves`-th file in place."""
    move, left = files.move, count(1 - moves)

    def stopping(scratch, path, **more):
        move(scratch, path, **more)
        if path.is_relative_to(out) and next(left) == 0:
            raise stop

    monkeypatch.setattr(files, "move", stopping)


@pytest.mark.parametrize(
    ("name", "more", "evaluations"),
    [("ppo", [], 3), ("ppo", ["--patience", "1"], 2), ("sac", [], 3), ("student", [], 3)],
)
def test_stopped_after_any_file_it_is_the_whole(tmp_path, monkeypatch, name, more, evaluations):
    """Evaluations, card and policy are the same to the last bit, and there is a report."""
    if "--patience" in more:  # no evaluation is good enough to go on
        monkeypatch.setattr(evaluations_module, "BETTER", 10.0)
    given, whole = [*options(tmp_path, name), *more], tmp_path / "whole"
    main(["train", *given, "--out", str(whole)])
    results = json.loads((whole / "evaluations.json").read_text())["results"]
    assert len(results) == evaluations
    for moves in count(1):
        out = tmp_path / f"stopped-{moves}"
        stop = (Killed, KeyboardInterrupt)[moves % 2]
        with monkeypatch.context() as patch:
            stop_after(patch, out, moves, stop)
            try:
                main(["train", *given, "--out", str(out)])
            except (stop, SystemExit):
                pass
            else:
                break
        if finished(out):
            continue  # it was stopped after its last file
        resume = ["--resume"] if (out / "model.zip").exists() else []
        main(["train", *given, "--out", str(out), *resume])
        for file in FILES:
            assert (out / file).read_bytes() == (whole / file).read_bytes(), (moves, file)
        assert (out / "report.html").exists(), moves
    assert moves > 10
