"""`activesuit list`: suits, tasks and policies; and the options --task and --level."""

import json
import re

import numpy as np
import pytest
from activesuit.assets import JOINTS, Suit, SuitJoint, load_suit, suit_names
from activesuit.envs import TASKS
from activesuit.envs.domain.levels import LEVELS
from activesuit.envs.policies import POLICIES
from activesuit.envs.policies.trained import shipped_policies
from activesuit.hysteresis import JilesAtherton
from helpers import fails, run

RISKY = JilesAtherton(Ms=22.2316, a=319.55, alpha=6.3223, c=4.7447, k=168.582, angle_unit="deg")
SAFE = load_suit("mock-suit").joints["elbow_flexion"].model
ABOUT = ("label", "pressure_kpa", "description")
LOSS_FACTORS = {  # the table in docs/model.md
    "emu-like": (0.836, 0.876, 0.796, 0.770),
    "exploration-56kpa": (0.658, 0.716, 0.605, 0.582),
    "mock-suit": (0.836, 0.753, 0.643, 0.770),
    "published-2022": (0.842, 0.751, 0.642, 0.770),
}


def test_the_list_has_label_pressure_joints_and_loss_factors(capsys):
    listed = json.loads(run(capsys, "list", "suits", "--json"))
    assert [*listed] == suit_names()
    shown = run(capsys, "list", "suits")
    for name, reported in listed.items():
        suit = load_suit(name)
        factors = [reported["loss_factor"][joint] for joint in JOINTS]
        assert factors == pytest.approx(LOSS_FACTORS[name], abs=6e-4)
        assert reported.keys() == {*ABOUT, "joints", "loss_factor"}
        assert [reported[field] for field in ABOUT] == [getattr(suit, field) for field in ABOUT]
        assert reported["joints"] == [*suit.joints]
        assert all(text in shown for text in (name, suit.label, suit.description))
    assert "29.6 kPa" in shown
    mock = run(capsys, "list", "suits", "mock-suit")
    assert re.search(r"loss factor +0\.75 +0\.64 +0\.84 +0\.77", mock)


@pytest.mark.parametrize("name", ["mock-suit", "emu-like", "exploration-56kpa"])
def test_a_safe_suit_is_shown(capsys, name):
    shown = run(capsys, "list", "suits", name)
    assert "Safe to simulate" in shown
    assert "NO" not in shown.replace("NRMSE", "").split()
    found = json.loads(run(capsys, "list", "suits", name, "--json"))
    assert found["safe"]
    assert all(found["joints"][joint]["certificate"]["margin"] > 0 for joint in JOINTS)


def unsafe(capsys, *arguments):
    """Returns what is shown of a suit that is not safe to simulate, and the sentence."""
    with pytest.raises(SystemExit):
        run(capsys, "list", "suits", *arguments)
    return capsys.readouterr().out, fails(capsys, "list", "suits", *arguments, shown=True)


def test_an_unsafe_suit_is_shown_and_ends_with_exit_code_2(capsys):
    shown, message = unsafe(capsys, "published-2022")
    assert "NO" in shown and "Safe to simulate" not in shown
    assert "shoulder_flexion: the certificate margin is -0.245" in message
    assert "elbow" not in message
    found = json.loads(unsafe(capsys, "published-2022", "--json")[0])
    assert not found["safe"]
    margin = found["joints"]["shoulder_flexion"]["certificate"]["margin"]
    assert margin == pytest.approx(-0.2447, abs=1e-4)


def saved(path, model, **changes):
    """Writes a suit file with an elbow; returns the path."""
    given = {"range": (0.0, 1.5), "start_angle": 0.0, "grade": "assumed", "source": "a test"}
    joint = SuitJoint(model=model, **(given | changes))
    Suit(name="own", description="", joints={"elbow_flexion": joint}).save(path)
    return path


def test_a_joint_without_a_steady_cycle_has_no_loss_factor(capsys, tmp_path):
    file = saved(tmp_path / "s.json", RISKY, range=(0.0, 2.5))
    found = json.loads(unsafe(capsys, file, "--json")[0])
    assert found["joints"]["elbow_flexion"]["loss_factor"] is None
    assert re.search(r"loss factor +-", unsafe(capsys, file)[0])


def test_a_start_outside_the_certificate_is_found(capsys, tmp_path):
    _, message = unsafe(capsys, saved(tmp_path / "s.json", SAFE, start_torque=12.0))
    assert "the start of joint 'elbow_flexion' at 0 rad, 12 N·m lies outside" in message


def test_samples_are_shown(capsys, tmp_path):
    samples = [SAFE.scaled(torque=factor) for factor in (0.8, 1.2, 1.1)]
    shown = run(capsys, "list", "suits", saved(tmp_path / "s.json", SAFE, samples=samples))
    torque = SAFE.response([0, 1.5])[-1]
    assert f"{0.8 * torque:.2f} .. {1.2 * torque:.2f}" in shown


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
    assert (reported["failures"], reported["task"]) == (0, str(file))


def test_lists_every_policy(capsys):
    out = run(capsys, "list", "policies")
    found = json.loads(run(capsys, "list", "policies", "--json"))
    assert list(found) == [*POLICIES, *shipped_policies()]
    for name, one in found.items():
        assert name in out
        assert one["does"].endswith(".")
    assert found["adaptive"]["sensors"] == ["encoders", "interaction"]
    assert {"suit", "load", "wearer", "forgetting"} <= set(found["adaptive"]["options"])
    given = next(iter(shipped_policies().items()))
    by_name, by_folder = (json.loads(run(capsys, "list", "policies", x, "--json")) for x in given)
    assert by_name[given[0]] == by_folder[given[1]]
    assert "unknown policy 'magic'" in fails(capsys, "list", "policies", "magic")
