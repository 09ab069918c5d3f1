"""`activesuit tasks`, and the options --task and --level."""

import json

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import TASKS
from activesuit.envs.levels import LEVELS
from activesuit.scripts.commands import tasks as command
from helpers import run, shorten_tasks


@pytest.fixture
def short(monkeypatch):
    shorten_tasks(monkeypatch, 0.5)


def test_lists_every_task(capsys):
    out = run(capsys, "tasks")
    reported = json.loads(run(capsys, "tasks", "--json"))
    assert list(reported) == list(TASKS)
    for name, task in TASKS.items():
        assert f"ActiveSuit/{name}-v0" in out
        assert reported[name]["rule"] == task.rule
        assert reported[name]["source"]
        assert reported[name]["about"].endswith(".")


@pytest.mark.slow
def test_an_interrupted_table_goes_on(capsys, tmp_path, short, monkeypatch):
    arguments = ["tasks", "--table", "--only", "Ratchet", "--episodes", 8, "--out", tmp_path]
    run(capsys, *arguments, "--levels", "nominal")
    measured, difficulty = [], command.difficulty

    def counted(task, level, *rest):
        measured.append((task, level))
        return difficulty(task, level, *rest)

    monkeypatch.setattr(command, "difficulty", counted)
    found = json.loads(run(capsys, *arguments, "--levels", "nominal", "shift", "--json"))
    assert measured == [("Ratchet", "shift")]
    first, second = (setting["scores"] for setting in found["settings"])
    assert set(first) == set(second) == set(command.SHOWN)
    assert first["best-known-plan"]["effort"] != second["best-known-plan"]["effort"]
    page = (tmp_path / "tasks.md").read_text()
    assert page.count("| Ratchet |") == 2
    run(capsys, *arguments[:-2], "--seed", 3, "--levels", "nominal", "--out", tmp_path)
    assert measured[-1] == ("Ratchet", "nominal")  # other motions are not those on disk


def test_the_wrong_model_is_believed_and_the_right_one_is_simulated(short):
    scores = command.difficulty("ElbowFlexion", "nominal", 1, 0).scores
    suits = {
        name: scores[name].human_rms["elbow_flexion"] for name in ("right model", "wrong model")
    }
    assert suits["wrong model"] > 1.2 * suits["right model"]


def simulated(capsys, tmp_path, *arguments):
    options = ["--json", "--force", "--out", tmp_path / "motion"]
    run(capsys, "simulate", *arguments, *options)
    return json.loads((tmp_path / "motion" / "result.json").read_text())


@pytest.mark.slow
def test_a_task_brings_its_place_and_a_level_its_suit(capsys, tmp_path, short, undrawn):
    reported = simulated(capsys, tmp_path, "--task", "Handrail")
    assert (reported["env"], reported["gravity"]) == ("ActiveSuit/Handrail-v0", "microgravity")
    reported = simulated(capsys, tmp_path, "--task", "Handrail", "--gravity", "moon")
    assert reported["gravity"] == "moon"
    reported = simulated(capsys, tmp_path, "--task", "Scoop", "--level", "shift")
    assert {name: reported[name] for name in LEVELS["shift"]} == LEVELS["shift"]
    reported = simulated(capsys, tmp_path, "--level", "shift", "--suit", "mock-suit")
    assert (reported["suit"], reported["pressure"]) == ("mock-suit", None)


def test_a_recorded_motion_is_simulated(capsys, tmp_path, undrawn):
    time = np.arange(0, 0.5, 0.02)
    angle = np.full((time.size, len(JOINTS)), [0, 0.6, 1.0, 0]) + 0.01 * time[:, None]
    file = tmp_path / "my.csv"
    names = ",".join(["time", *JOINTS])
    np.savetxt(file, np.column_stack([time, angle]), "%.6f", ",", header=names, comments="")
    reported = simulated(capsys, tmp_path, "--task", file)
    assert reported["failures"] == 0
    assert reported["task"] == str(file)
