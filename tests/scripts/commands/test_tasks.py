"""`activesuit list tasks`, and the options --task and --level."""

import json

import numpy as np
import pytest
from activesuit.assets import JOINTS
from activesuit.envs import TASKS
from activesuit.envs.domain.levels import LEVELS
from helpers import run, shorten_tasks


@pytest.fixture
def short(monkeypatch):
    shorten_tasks(monkeypatch, 0.5)


def test_lists_every_task(capsys):
    out = run(capsys, "list", "tasks")
    reported = json.loads(run(capsys, "list", "tasks", "--json"))
    assert list(reported) == list(TASKS)
    for name, task in TASKS.items():
        assert f"ActiveSuit/{name}-v0" in out
        assert reported[name]["rule"] == task.rule
        assert reported[name]["source"]
        assert reported[name]["about"].endswith(".")
    assert [*json.loads(run(capsys, "list", "tasks", "Ratchet", "--json"))] == ["Ratchet"]


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
